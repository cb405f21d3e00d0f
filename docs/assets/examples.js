// Whole programs among the examples get a link that opens them in the playground of this site.
// A page that is read from a file has none: browsers run no Python from files.
if (location.protocol.startsWith("http")) {
  const { base } = JSON.parse(document.getElementById("__config").textContent);
  const playground = new URL(`${base}/playground/index.html`, location.href);
  for (const example of document.querySelectorAll(".highlight code")) {
    const text = example.textContent;
    if (!/^kind: program$/m.test(text)) continue;
    const link = document.createElement("a");
    link.href = `${playground}#${new URLSearchParams({ text })}`;
    link.textContent = "Open in the playground";
    example.closest(".highlight").after(link);
  }
}
