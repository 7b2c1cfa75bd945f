"""The contrast of text as a browser shows it, by the formula of WCAG 2: a script for pages, and what each must reach."""

TEXT, LARGE = 4.5, 3.0

# [ratio, whether the letters are large, where] for each pair of colours in the page
CONTRAST = """() => {
  const linear = v => { v /= 255; return v <= 0.04045 ? v / 12.92 : Math.pow((v + 0.055) / 1.055, 2.4); };
  const rgb = text => (text.match(/[\\d.]+/g) || [0, 0, 0, 0]).map(Number);
  const light = c => 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
  const ground = e => { for (; e; e = e.parentElement) { const c = rgb(getComputedStyle(e).backgroundColor);
    if (c.length === 3 || c[3] > 0.99) return c; } return [255, 255, 255]; };
  const found = {};
  for (const e of document.querySelectorAll("main *, article *, nav *, aside *")) {
    if (!e.checkVisibility() || ![...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim())) continue;
    const style = getComputedStyle(e), drawn = e.closest("svg");
    const front = rgb(drawn ? style.fill : style.color), back = ground(e);
    const [a, b] = [light(front), light(back)].sort((x, y) => y - x), ratio = (a + 0.05) / (b + 0.05);
    const size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.66 && style.fontWeight >= 700);
    const key = [front, back, large].join();
    if (!(key in found)) found[key] = [ratio, large, e.tagName + "." + e.className + ": " + e.textContent.trim().slice(0, 40)];
  }
  return Object.values(found);
}"""
