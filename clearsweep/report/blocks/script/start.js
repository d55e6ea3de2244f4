for (const root of document.querySelectorAll(".explorer")) new Explorer(root);
for (const root of document.querySelectorAll(".player")) new Player(root);
for (const root of document.querySelectorAll(".worn")) new Worn(root);
