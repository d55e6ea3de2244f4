// Search in the browser. The index is a script, as pages that are opened from the disk may not fetch files.
"use strict";
const MOST = 30; // results that are shown
const AROUND = 80; // characters of text on both sides of a match
const field = document.getElementById("query");
const results = document.getElementById("results");
const article = document.querySelector("article");
const sections = window.searchIndex.map((entry) => ({
  ...entry,
  lowerTitle: entry.title.toLowerCase(),
  lowerText: entry.text.toLowerCase(),
}));

// Returns how well a section matches all words, 0 where one of them is missing. Words in the title count most.
function score(section, words) {
  let total = 0;
  for (const word of words) {
    const inTitle = section.lowerTitle.includes(word);
    const inText = section.lowerText.split(word).length - 1;
    if (!inTitle && !inText) return 0;
    total += (inTitle ? 20 : 0) + (section.lowerTitle === word ? 40 : 0) + Math.min(inText, 10);
  }
  return section.location.startsWith("reference/") ? total / 4 : total;
}

function excerpt(section, word) {
  const place = Math.max(section.lowerText.indexOf(word), 0);
  const start = Math.max(place - AROUND, 0);
  return (start ? "…" : "") + section.text.slice(start, place + AROUND) + "…";
}

function element(tag, text, properties = {}) {
  return Object.assign(document.createElement(tag), { textContent: text }, properties);
}

function show() {
  const words = field.value.toLowerCase().split(/\s+/).filter((word) => word.length > 1);
  article.hidden = words.length > 0;
  results.hidden = !article.hidden;
  const matches = sections
    .map((section) => [score(section, words), section])
    .filter(([value]) => value > 0)
    .sort((a, b) => b[0] - a[0]);
  results.replaceChildren(element("h1", `${matches.length} results`));
  for (const [, section] of matches.slice(0, MOST)) {
    const link = element("a", section.title, { href: `${field.dataset.root}/${section.location}` });
    link.addEventListener("click", () => { field.value = ""; show(); });
    const heading = element("h2", "");
    heading.append(link);
    results.append(heading, element("p", section.page, { className: "page" }), element("p", excerpt(section, words[0])));
  }
}

field.addEventListener("input", show);
field.value = new URLSearchParams(window.location.search).get("q") ?? ""; // a search has an address
if (field.value) show();
field.form.addEventListener("submit", (event) => {
  event.preventDefault();
  results.querySelector("a")?.click();
});
