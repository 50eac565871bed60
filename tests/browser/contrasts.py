"""Text that is hard to read, by what a browser computes of its style."""

from selenium.webdriver import Chrome

FAINT = """
const channels = (text) => {
  const [r, g, b, a] = (text.match(/[\\d.]+/g) || [0, 0, 0, 0]).map(Number);
  return [r, g, b, a === undefined ? 1 : a];
};
const over = (front, back, a) =>
  front.slice(0, 3).map((x, k) => a * x + (1 - a) * back[k]);
const behind = (element) => {
  if (!element) return [255, 255, 255];
  const own = channels(getComputedStyle(element).backgroundColor);
  return own[3] === 1 ? own : over(own, behind(element.parentElement), own[3]);
};
const opaque = (element) =>
  element ? getComputedStyle(element).opacity * opaque(element.parentElement) : 1;
const luminance = (rgb) => rgb.slice(0, 3)
  .map((x) => x / 255 <= 0.04045 ? x / 255 / 12.92 : ((x / 255 + 0.055) / 1.055) ** 2.4)
  .reduce((sum, x, k) => sum + x * [0.2126, 0.7152, 0.0722][k], 0);
return [...document.querySelectorAll(arguments[0])].flatMap((root) => {
  const faint = [];
  for (const each of [root, ...root.querySelectorAll("*")]) {
    const text = [...each.childNodes].filter((n) => n.nodeType === Node.TEXT_NODE)
      .map((n) => n.data.trim()).join(" ").trim();
    // What stands on the cells of a heat map has no element behind it that says so.
    if (!/[\\p{L}\\p{N}]/u.test(text) || each.closest("script, style, .heatmap-label")
      || !each.checkVisibility({visibilityProperty: true})) continue;
    const style = getComputedStyle(each), back = behind(each);
    const ink = channels(each instanceof SVGElement ? style.fill : style.color);
    const [a, b] = [over(ink, back, ink[3] * opaque(each)), back].map(luminance);
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < arguments[1]) faint.push(`${ratio.toFixed(2)} ${text.slice(0, 40)}`);
  }
  return faint;
});
"""

LEAST = 4.5
"""The least contrast of text that WCAG 2 asks for (1.4.3)."""


def faint_texts(browser: Chrome, where: str) -> list[str]:
    """Texts with less contrast to what is behind them, each with its contrast.

    Args:
        browser: shows a page.
        where: a CSS selector of what is searched.
    """
    return browser.execute_script(FAINT, where, LEAST)
