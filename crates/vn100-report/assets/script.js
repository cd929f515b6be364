// What a report does beside its figures.
{
  const alive = vn100.enliven(JSON.parse(document.getElementById('readings').textContent));
  const contents = document.querySelector('nav');
  if (contents) {
    const hint = document.createElement('p');
    hint.className = 'lead tools';
    hint.textContent = matchMedia('(pointer: coarse)').matches
      ? 'Figures: touch a value to read it; Enlarge fills the screen. Wide tables scroll sideways.'
      : 'Figures: point at a value to read it, drag to move, Shift and drag or double-click to zoom; by keyboard: arrows, + − 0.';
    contents.after(hint);
  }
  vn100.tables(document);
  // paper has no triangle to click on
  window.addEventListener('beforeprint', () => document.querySelectorAll('details').forEach((details) => { details.open = true; }));
  document.documentElement.dataset.ready = String(alive);
}
