for (const map of document.querySelectorAll("figure svg:has(a .spot)")) new Cells(map);
for (const root of document.querySelectorAll(".explorer")) new Explorer(root);
for (const root of document.querySelectorAll(".player")) new Player(root);
for (const root of document.querySelectorAll(".worn")) new Worn(root);
