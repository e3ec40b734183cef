"""What anybody needs of a page, checked in the browser: names of controls, labels, contrast, one heading, unique ids.

The contrast is that of WCAG 2.1, 1.4.3: at least 4.5 to 1 for text, against the nearest opaque background. Controls that
are disabled are exempt, as there.
"""

RULES = r"""
const broken = [];
const visible = (element) => element.getClientRects().length > 0 && getComputedStyle(element).visibility === 'visible';
const name = (element) => (element.getAttribute('aria-label')
  || (element.getAttribute('aria-labelledby') || '').split(' ').map((id) => document.getElementById(id)?.textContent || '').join(' ')
  || [...(element.labels || [])].map((label) => label.textContent).join(' ') || element.textContent || '').trim();
const ids = [...document.querySelectorAll('[id]')].map((element) => element.id);
ids.filter((id, place) => ids.indexOf(id) !== place).forEach((id) => broken.push(`two elements are called ${id}`));
if (document.querySelectorAll('h1').length !== 1) broken.push('not one heading');
if (!document.documentElement.lang) broken.push('no language');
for (const attribute of ['aria-controls', 'aria-labelledby', 'aria-describedby', 'for']) {
  for (const element of document.querySelectorAll(`[${attribute}]`)) {
    if (!document.getElementById(element.getAttribute(attribute))) broken.push(`${attribute} of ${element.id} leads nowhere`);
  }
}
for (const element of document.querySelectorAll('button, input, select, textarea, [tabindex], [role=img]')) {
  const isName = element.matches('input, select, textarea')
    ? element.labels.length > 0 || element.hasAttribute('aria-label') : true;
  if (visible(element) && !(isName && name(element))) broken.push(`no name: ${element.outerHTML.slice(0, 90)}`);
}
const parse = (color) => { const part = color.match(/[\d.]+/g).map(Number); return part.length < 4 ? [...part, 1] : part; };
const channel = (level) => { const c = level / 255; return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; };
const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
const over = (top, below) => [0, 1, 2].map((i) => top[i] * top[3] + below[i] * (1 - top[3]));
const backdrop = (element) => {
  if (!element) return [255, 255, 255];
  const own = parse(getComputedStyle(element).backgroundColor);
  return own[3] === 1 ? own.slice(0, 3) : over(own, backdrop(element.parentElement));
};
for (const element of document.querySelectorAll('body *')) {
  const says = [...element.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.data.trim());
  const isText = says || element.matches('input, textarea, select');
  if (!isText || !visible(element) || element.matches(':disabled, :disabled *, [aria-hidden=true], [aria-hidden=true] *, option, script')) continue;
  const style = getComputedStyle(element);
  const below = backdrop(element);
  const levels = [light(over(parse(style.color), below)), light(below)].sort((a, b) => b - a);
  const contrast = (levels[0] + 0.05) / (levels[1] + 0.05);
  if (contrast < 4.5) broken.push(`contrast ${contrast.toFixed(2)}: ${element.outerHTML.slice(0, 90)}`);
}
return broken;
"""
