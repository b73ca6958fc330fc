"use strict";
// Without this script the page is whole: only the button that copies would be missing.
const parts = document.querySelectorAll("details.part");
let closed = [];
addEventListener("beforeprint", () => {
  closed = [...parts].filter((part) => !part.open);
  closed.forEach((part) => { part.open = true; });
});
addEventListener("afterprint", () => closed.forEach((part) => { part.open = false; }));

const paper = document.getElementById("paper_text");
const button = document.getElementById("copy");
button.hidden = false;
button.addEventListener("click", async () => {
  try {
    await navigator.clipboard.writeText(paper.textContent);
    button.textContent = "Copied";
  } catch {  // not allowed on pages opened from a file: leave the text selected
    getSelection().selectAllChildren(paper);
    button.textContent = document.execCommand("copy") ? "Copied" : "Selected: press Ctrl+C";
  }
});
