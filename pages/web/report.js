// What a page does besides showing text. Without it everything but the charts is still there.
"use strict";
(() => {
  // "Copy" beside a command.
  for (const button of document.querySelectorAll("button[data-copy]")) {
    const source = document.getElementById(button.dataset.copy);
    button.addEventListener("click", async () => {
      const selection = getSelection();
      selection.selectAllChildren(source);
      try {
        await navigator.clipboard.writeText(source.textContent);
      } catch {  // a page opened from disk may not: an older way still works in most browsers
        document.execCommand("copy");
      }
      button.textContent = "Copied";
      setTimeout(() => { button.textContent = "Copy"; }, 1500);
    });
  }
})();
