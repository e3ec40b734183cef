for (const button of document.querySelectorAll('.answers button')) {
  button.addEventListener('click', async () => {
    const range = document.createRange();
    range.selectNodeContents(button.previousElementSibling);
    const selection = getSelection();
    selection.removeAllRanges();
    selection.addRange(range);
    // A page that is opened as a file may be refused the clipboard, but not the command of the browser.
    let copied = document.execCommand('copy');
    if (!copied && navigator.clipboard) {
      copied = await navigator.clipboard.writeText(button.previousElementSibling.textContent).then(() => true, () => false);
    }
    button.textContent = copied ? 'Copied' : 'Press Ctrl-C';
    setTimeout(() => { button.textContent = 'Copy'; }, 1500);
  });
}
