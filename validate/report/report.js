// What a plot's point says, at once and under a finger too; without this the browser shows the <title> by itself.
(() => {
  const tip = document.createElement('div');
  tip.id = 'tip';
  tip.setAttribute('role', 'status');
  document.body.append(tip);
  for (const point of document.querySelectorAll('svg .tip')) {
    const title = point.querySelector('title');
    point.dataset.tip = title.textContent;
    point.setAttribute('aria-label', title.textContent);
    title.remove();
  }
  const show = (event) => {
    const point = event.target instanceof Element ? event.target.closest('.tip') : null;
    tip.hidden = !point;
    if (!point) return;
    tip.textContent = point.dataset.tip;
    const box = point.getBoundingClientRect();
    const left = Math.min(box.right + 8, document.documentElement.clientWidth - tip.offsetWidth - 8);
    tip.style.left = `${Math.max(8, left)}px`;
    tip.style.top = `${box.top > tip.offsetHeight + 12 ? box.top - tip.offsetHeight - 6 : box.bottom + 6}px`;
  };
  document.addEventListener('pointerover', show);
  document.addEventListener('scroll', () => { tip.hidden = true; }, { passive: true, capture: true });
  tip.hidden = true;
  // paper shows everything
  addEventListener('beforeprint', () => { for (const more of document.querySelectorAll('details')) more.open = true; });
})();
