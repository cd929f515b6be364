// Hover values, switches for the series, and zoom. The page says everything without it.
'use strict';
(() => {
  const readings = JSON.parse(document.getElementById('readings').textContent);
  const svg = (name, attributes) => {
    const element = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const key in attributes) element.setAttribute(key, attributes[key]);
    return element;
  };
  const number = (value) => {
    if (value === null) return '–';
    if (value === 0) return '0';
    const size = Math.abs(value);
    return size >= 1e-2 && size < 1e5 ? String(+value.toPrecision(5)) : value.toExponential(3).replace('e', '·10^');
  };
  const share = (side, value) => side.log
    ? Math.log(value / side.from) / Math.log(side.to / side.from)
    : (value - side.from) / (side.to - side.from);
  const value = (side, part) => side.log
    ? side.from * Math.pow(side.to / side.from, part)
    : side.from + (side.to - side.from) * part;
  const raised = (power) => String(power).replace(/./g, (c) => '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'['-0123456789'.indexOf(c)]);

  // places and labels of ticks, as in the figure without script
  const ticks = (side) => {
    const found = [];
    if (side.log) {
      const decades = Math.log10(side.to / side.from);
      for (let e = Math.floor(Math.log10(side.from)); e <= Math.ceil(Math.log10(side.to)); e++) {
        for (let d = 1; d <= 9; d++) {
          const at = d * Math.pow(10, e);
          if (at < side.from || at > side.to) continue;
          const told = d === 1 || ((d === 2 || d === 5) && decades < 1.6) || decades < 0.6;
          const plain = e >= -2 && e <= 4;
          found.push([at, told ? (plain ? String(+at.toPrecision(6)) : (d === 1 ? '' : d + '·') + '10' + raised(e)) : '']);
        }
      }
    } else {
      const raw = (side.to - side.from) / 6.5, power = Math.pow(10, Math.floor(Math.log10(raw)));
      const step = power * [1, 2, 2.5, 5, 10].find((nice) => nice * power >= raw);
      for (let n = Math.ceil(side.from / step); n * step <= side.to; n++) found.push([n * step, String(+(n * step).toPrecision(6))]);
    }
    return found;
  };

  let alive = 0;
  for (const reading of readings) {
    const figure = document.getElementById('figure-' + reading.id);
    if (!figure) continue;
    const picture = figure.querySelector('svg');
    const [left, top, width, height] = reading.area;
    const whole = { x: reading.x, y: reading.y };
    let shown = { x: { ...reading.x }, y: { ...reading.y } };
    const hidden = new Set();
    const cross = svg('path', { class: 'l quiet', fill: 'none', 'stroke-width': '0.8', 'stroke-dasharray': '2 2' });
    const readout = document.createElement('div');
    readout.className = 'readout';
    readout.hidden = true;
    picture.append(cross);
    figure.append(readout);

    const place = (event) => {
      const box = picture.getBoundingClientRect(), view = picture.viewBox.baseVal;
      return [(event.clientX - box.left) * view.width / box.width, (event.clientY - box.top) * view.height / box.height];
    };
    const inside = ([x, y]) => x >= left && x <= left + width && y >= top && y <= top + height;
    const toX = (v) => left + width * share(shown.x, v);
    const toY = (v) => top + height * (1 - share(shown.y, v));

    // the nearest value of each series that is shown
    const hover = (event) => {
      const at = place(event);
      if (!inside(at)) { readout.hidden = true; cross.setAttribute('d', ''); return; }
      let nearest = null;
      reading.series.forEach((series, index) => {
        if (hidden.has(index)) return;
        series.x.forEach((x, i) => {
          const dx = toX(x) - at[0], dy = toY(series.y[i]) - at[1];
          const far = dx * dx + 0.15 * dy * dy;
          if (Number.isFinite(far) && (!nearest || far < nearest.far)) nearest = { far, series, i };
        });
      });
      if (!nearest) return;
      const { series, i } = nearest, x = series.x[i], y = series.y[i], reach = series.reach && series.reach[i];
      readout.replaceChildren();
      const lines = [series.name, reading.x.name + ' ' + number(x) + ' ' + reading.x.unit, number(y) + ' ' + reading.y.unit];
      if (reach) lines.push(number(reach[0]) + ' to ' + number(reach[1]));
      lines.forEach((text, n) => { if (n) readout.append(document.createElement('br')); readout.append(text); });
      readout.hidden = false;
      const [px, py] = [toX(x), toY(y)];
      cross.setAttribute('d', `M${px} ${top}V${top + height}M${left} ${Math.min(Math.max(py, top), top + height)}H${left + width}`);
      const scale = picture.getBoundingClientRect().width / picture.viewBox.baseVal.width;
      const right = px * scale + 12 + readout.offsetWidth > figure.clientWidth;
      readout.style.left = Math.max(0, right ? px * scale - 12 - readout.offsetWidth : px * scale + 12) + 'px';
      readout.style.top = picture.offsetTop + Math.max(0, py * scale - readout.offsetHeight - 8) + 'px';
    };
    picture.addEventListener('pointermove', hover);
    picture.addEventListener('pointerdown', hover);
    picture.addEventListener('pointerleave', () => { readout.hidden = true; cross.setAttribute('d', ''); });

    // zoom: what is drawn is moved, and the frame is drawn anew
    const frame = picture.querySelector('g.frame');
    const original = frame.innerHTML;
    const drawn = [...picture.querySelectorAll('g.data > *')].map((element) => {
      const moved = /translate\(([-\d.]+) ([-\d.]+)\)/.exec(element.getAttribute('transform') || '');
      return { element, at: moved ? [+moved[1], +moved[2]] : null };
    });
    const redraw = () => {
      const same = ['x', 'y'].every((s) => shown[s].from === whole[s].from && shown[s].to === whole[s].to);
      reset.hidden = same;
      const ax = [toX(value(whole.x, 0)), toX(value(whole.x, 1))], ay = [toY(value(whole.y, 1)), toY(value(whole.y, 0))];
      const kx = (ax[1] - ax[0]) / width, ky = (ay[1] - ay[0]) / height;
      for (const { element, at } of drawn) {
        if (at) element.setAttribute('transform', `translate(${ax[0] + kx * (at[0] - left)} ${ay[0] + ky * (at[1] - top)})`);
        else element.setAttribute('transform', `matrix(${kx} 0 0 ${ky} ${ax[0] - kx * left} ${ay[0] - ky * top})`);
      }
      if (same) { frame.innerHTML = original; return; }
      const texts = [...frame.querySelectorAll('text')].slice(-2).map((text) => text.cloneNode(true));
      frame.replaceChildren();
      const line = (d, kind) => frame.append(svg('path', { class: 'l ' + kind, fill: 'none', 'stroke-width': '0.8', d }));
      const label = (x, y, text, anchor) => {
        // small at the side: there may be longer numbers than the room was made for
        const element = svg('text', { x, y, 'font-size': anchor === 'end' ? '9' : '11.5', 'text-anchor': anchor });
        element.textContent = text.replace('-', '−');
        frame.append(element);
      };
      for (const [at, text] of ticks(shown.x)) {
        line(`M${toX(at)} ${top}V${top + height}`, text ? 'grid' : 'fine');
        if (text) label(toX(at), top + height + 15.5, text, 'middle');
      }
      for (const [at, text] of ticks(shown.y)) {
        line(`M${left} ${toY(at)}H${left + width}`, text ? 'grid' : 'fine');
        if (text) label(left - 5, toY(at) + 4, text, 'end');
      }
      line(`M${left} ${top}h${width}v${height}h${-width}z`, 'axis');
      texts[0].textContent = reading.x.name + ' (' + reading.x.unit + ')';
      texts[1].textContent = reading.y.name + (reading.y.unit ? ' (' + reading.y.unit + ')' : '');
      frame.append(...texts);
    };
    const zoom = (event, factor) => {
      const at = place(event);
      if (!inside(at)) return;
      for (const [name, part] of [['x', (at[0] - left) / width], ['y', 1 - (at[1] - top) / height]]) {
        const side = shown[name], middle = value(side, part);
        const bound = (end) => side.log ? middle * Math.pow(end / middle, factor) : middle + (end - middle) * factor;
        let from = bound(side.from), to = bound(side.to);
        const full = whole[name];
        if (from <= full.from || share(full, to) - share(full, from) > 0.98) from = full.from;
        if (to >= full.to) to = full.to;
        shown[name] = { ...side, from, to };
      }
      redraw();
      hover(event);
    };
    picture.addEventListener('wheel', (event) => {
      if (!(event.ctrlKey || event.shiftKey) || !inside(place(event))) return;
      event.preventDefault();
      zoom(event, event.deltaY + event.deltaX > 0 ? 1.4 : 1 / 1.4);
    }, { passive: false });
    picture.addEventListener('dblclick', (event) => zoom(event, 0.5));

    const tools = document.createElement('div');
    tools.className = 'tools';
    if (reading.series.length > 1) {
      reading.series.forEach((series, index) => {
        const box = document.createElement('label'), input = document.createElement('input');
        input.type = 'checkbox';
        input.checked = true;
        input.addEventListener('change', () => {
          hidden[input.checked ? 'delete' : 'add'](index);
          picture.querySelectorAll('g.s' + index).forEach((layer) => { layer.style.display = input.checked ? '' : 'none'; });
        });
        box.append(input, ' ', series.name);
        tools.append(box);
      });
    }
    const reset = document.createElement('button');
    reset.type = 'button';
    reset.textContent = 'whole figure';
    reset.hidden = true;
    reset.addEventListener('click', () => { shown = { x: { ...whole.x }, y: { ...whole.y } }; redraw(); });
    tools.append(reset);
    figure.append(tools);
    alive += 1;
  }
  const contents = document.querySelector('nav');
  if (contents) {
    const hint = document.createElement('p');
    hint.className = 'lead tools';
    hint.textContent = 'In the figures: point at a value to read it; double-click, or Ctrl and wheel, to zoom.';
    contents.after(hint);
  }
  // paper has no triangle to click on
  window.addEventListener('beforeprint', () => document.querySelectorAll('details').forEach((details) => { details.open = true; }));
  document.documentElement.dataset.ready = String(alive);
})();
