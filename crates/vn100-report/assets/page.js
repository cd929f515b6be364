// Hover values, switches for the series, and zoom; a live page follows the program. A page says
// everything without it.
'use strict';
const vn100 = (() => {
  // what was chosen of each figure, for when it is drawn anew
  const kept = new Map();
  const svg = (name, attributes) => {
    const element = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const key in attributes) element.setAttribute(key, attributes[key]);
    return element;
  };
  const raised = (power) => String(power).replace(/./g, (c) => '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'['-0123456789'.indexOf(c)]);
  const number = (value) => {
    if (value === null) return '–';
    if (value === 0) return '0';
    const size = Math.abs(value);
    if (size >= 1e-2 && size < 1e5) return String(+value.toPrecision(4)).replace('-', '−');
    const [digits, power] = value.toExponential(2).split('e');
    return digits.replace('-', '−') + '·10' + raised(+power);
  };
  const share = (side, value) => side.log
    ? Math.log(value / side.from) / Math.log(side.to / side.from)
    : (value - side.from) / (side.to - side.from);
  const value = (side, part) => side.log
    ? side.from * Math.pow(side.to / side.from, part)
    : side.from + (side.to - side.from) * part;

  // places and labels of ticks, as in the figure without script
  const ticks = (side) => {
    const found = [];
    if (side.log) {
      const decades = Math.log10(side.to / side.from);
      const isPlain = (power) => power >= -2 && power <= 4;
      const plain = isPlain(Math.ceil(Math.log10(side.from))) && isPlain(Math.floor(Math.log10(side.to)));
      for (let e = Math.floor(Math.log10(side.from)); e <= Math.ceil(Math.log10(side.to)); e++) {
        for (let d = 1; d <= 9; d++) {
          const at = d * Math.pow(10, e);
          if (at < side.from || at > side.to) continue;
          const labelled = d === 1 || ((d === 2 || d === 5) && decades < 1.6) || decades < 0.6;
          found.push([at, labelled ? (plain ? String(+at.toPrecision(6)) : (d === 1 ? '' : d + '·') + '10' + raised(e)) : '']);
        }
      }
    } else {
      const raw = (side.to - side.from) / 6.5, power = Math.pow(10, Math.floor(Math.log10(raw)));
      const step = power * [1, 2, 2.5, 5, 10].find((nice) => nice * power >= raw);
      for (let n = Math.ceil(side.from / step); n * step <= side.to; n++) found.push([n * step, String(+(n * step).toPrecision(6))]);
    }
    return found;
  };

  // Makes the figures below this element alive, and returns how many.
  const enliven = (root) => {
    let alive = 0;
    for (const data of root.querySelectorAll('figure > script')) {
      const figure = data.parentElement, reading = JSON.parse(data.textContent);
      if (!reading) continue;
      const picture = figure.querySelector('svg');
      const [left, top, width, height] = reading.area;
      const whole = { x: reading.x, y: reading.y };
      let shown = { x: { ...reading.x }, y: { ...reading.y } };
      const before = kept.get(reading.id) || { hidden: new Set(), enlarged: false };
      const hidden = before.hidden;
      let unit = { name: reading.y.unit, factor: 1 };
      const keep = () => kept.set(reading.id, { hidden, unit: unit.name, enlarged: figure.classList.contains('enlarged'), zoomed: reset.hidden ? null : shown });
      let drag = null;
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

      // at the place of the pointer, the nearest averaging time, frequency or time of all series
      let at = null;
      const hide = () => { at = null; readout.hidden = true; cross.setAttribute('d', ''); };
      const nearest = (target) => {
        let found = null;
        reading.series.forEach((series, index) => {
          if (hidden.has(index)) return;
          for (const x of series.x) {
            const far = Math.abs(toX(x) - target);
            if (Number.isFinite(far) && (!found || far < found.far)) found = { far, x };
          }
        });
        return found && found.x;
      };
      const show = (x) => {
        if (x === null) return hide();
        at = x;
        readout.replaceChildren();
        const line = (text) => { if (readout.childNodes.length) readout.append(document.createElement('br')); readout.append(text); };
        line(reading.x.name + ' ' + number(x) + ' ' + reading.x.unit);
        let highest = null;
        reading.series.forEach((series, index) => {
          const i = hidden.has(index) ? -1 : series.x.indexOf(x);
          if (i < 0) return;
          const y = series.y[i], reach = series.reach && series.reach[i];
          line((reading.series.length > 1 ? series.name + ': ' : '') + number(y * unit.factor) + ' ' + unit.name
            + (reach ? ' (' + number(reach[0] * unit.factor) + ' to ' + number(reach[1] * unit.factor) + ')' : ''));
          if (highest === null || y > highest) highest = y;
        });
        if (highest === null) return hide();
        readout.hidden = false;
        const [px, py] = [toX(x), Math.min(Math.max(toY(highest), top), top + height)];
        cross.setAttribute('d', `M${px} ${top}V${top + height}M${left} ${py}H${left + width}`);
        const scale = picture.getBoundingClientRect().width / picture.viewBox.baseVal.width;
        const right = px * scale + 12 + readout.offsetWidth > figure.clientWidth;
        readout.style.left = Math.max(0, right ? px * scale - 12 - readout.offsetWidth : px * scale + 12) + 'px';
        readout.style.top = Math.max(0, py * scale - readout.offsetHeight - 8) + 'px';
      };
      const hover = (event) => {
        const place_ = place(event);
        if (!inside(place_)) { if (event.pointerType === 'mouse') hide(); return; }
        show(nearest(place_[0]));
      };
      picture.addEventListener('pointermove', (event) => { if (!drag) hover(event); });
      // a finger leaves the values where it pointed
      picture.addEventListener('pointerleave', (event) => { if (event.pointerType === 'mouse') hide(); });
      picture.tabIndex = 0;
      const step = (by) => {
        const seen = (x) => x >= shown.x.from && x <= shown.x.to;
        const all = [...new Set(reading.series.flatMap((series, index) => hidden.has(index) ? [] : series.x))].filter(seen).sort((a, b) => a - b);
        if (!all.length) return;
        const place_ = at === null ? -1 : all.indexOf(at);
        show(all[Math.min(Math.max(place_ < 0 ? (by > 0 ? 0 : all.length - 1) : place_ + by, 0), all.length - 1)]);
      };
      picture.addEventListener('keydown', (event) => {
        const act = { ArrowRight: () => step(1), ArrowLeft: () => step(-1), '+': () => scaleAround([left + width / 2, top + height / 2], 0.7),
          '-': () => scaleAround([left + width / 2, top + height / 2], 1.4), '0': restore, Escape: hide }[event.key];
        if (act) { event.preventDefault(); act(); }
      });

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
        keep();
        const ax = [toX(value(whole.x, 0)), toX(value(whole.x, 1))], ay = [toY(value(whole.y, 1)), toY(value(whole.y, 0))];
        const kx = (ax[1] - ax[0]) / width, ky = (ay[1] - ay[0]) / height;
        for (const { element, at } of drawn) {
          if (at) element.setAttribute('transform', `translate(${ax[0] + kx * (at[0] - left)} ${ay[0] + ky * (at[1] - top)})`);
          else element.setAttribute('transform', `matrix(${kx} 0 0 ${ky} ${ax[0] - kx * left} ${ay[0] - ky * top})`);
        }
        if (same && unit.factor === 1) { frame.innerHTML = original; return; }
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
        for (const [at, text] of ticks({ ...shown.y, from: shown.y.from * unit.factor, to: shown.y.to * unit.factor })) {
          line(`M${left} ${toY(at / unit.factor)}H${left + width}`, text ? 'grid' : 'fine');
          if (text) label(left - 5, toY(at / unit.factor) + 4, text, 'end');
        }
        line(`M${left} ${top}h${width}v${height}h${-width}z`, 'axis');
        texts[0].textContent = reading.x.name + ' (' + reading.x.unit + ')';
        texts[1].textContent = reading.y.name + (unit.name ? ' (' + unit.name + ')' : '');
        frame.append(...texts);
      };
      const bounded = (name, from, to) => {
        const full = whole[name], side = shown[name];
        if (from <= full.from || share(full, to) - share(full, from) > 0.98) from = full.from;
        if (to >= full.to) to = full.to;
        shown[name] = { ...side, from, to };
      };
      const scaleAround = (around, factor) => {
        for (const [name, part] of [['x', (around[0] - left) / width], ['y', 1 - (around[1] - top) / height]]) {
          const side = shown[name], middle = value(side, part);
          const bound = (end) => side.log ? middle * Math.pow(end / middle, factor) : middle + (end - middle) * factor;
          bounded(name, bound(side.from), bound(side.to));
        }
        redraw();
        show(at);
      };
      const restore = () => { shown = { x: { ...whole.x }, y: { ...whole.y } }; redraw(); show(at); };
      picture.addEventListener('wheel', (event) => {
        if (!(event.ctrlKey || event.shiftKey) || !inside(place(event))) return;
        event.preventDefault();
        scaleAround(place(event), event.deltaY + event.deltaX > 0 ? 1.4 : 1 / 1.4);
      }, { passive: false });
      picture.addEventListener('dblclick', (event) => { if (inside(place(event))) scaleAround(place(event), 0.5); });

      // dragging moves what is shown; with Shift it draws the box to zoom to
      const box = svg('rect', { class: 'l ink', fill: 'none', 'stroke-width': '1', 'stroke-dasharray': '3 2', width: 0, height: 0 });
      picture.append(box);
      picture.addEventListener('pointerdown', (event) => {
        hover(event);
        if (event.pointerType !== 'mouse' || event.button !== 0 || !inside(place(event))) return;
        drag = { from: place(event), x: { ...shown.x }, y: { ...shown.y }, boxed: event.shiftKey };
        picture.setPointerCapture(event.pointerId);
        event.preventDefault();
        picture.focus();
      });
      picture.addEventListener('pointermove', (event) => {
        if (!drag) return;
        const to = place(event);
        if (drag.boxed) {
          const [x, y] = [0, 1].map((n) => Math.min(drag.from[n], to[n]));
          for (const [name, text] of [['x', x], ['y', y], ['width', Math.abs(to[0] - drag.from[0])], ['height', Math.abs(to[1] - drag.from[1])]]) box.setAttribute(name, text);
          return;
        }
        for (const [name, moved] of [['x', (drag.from[0] - to[0]) / width], ['y', (to[1] - drag.from[1]) / height]]) {
          const side = drag[name], full = whole[name];
          const low = share(full, value(side, moved)), high = share(full, value(side, 1 + moved));
          const back = low < 0 ? -low : high > 1 ? 1 - high : 0;
          shown[name] = { ...side, from: value(full, low + back), to: value(full, high + back) };
        }
        redraw();
      });
      const drop = (event) => {
        if (!drag) return;
        const { boxed, from } = drag, to = place(event);
        drag = null;
        box.setAttribute('width', 0);
        box.setAttribute('height', 0);
        if (boxed && Math.abs(to[0] - from[0]) > 5 && Math.abs(to[1] - from[1]) > 5) {
          const at_x = [from[0], to[0]].map((x) => value(shown.x, (x - left) / width)).sort((a, b) => a - b);
          const at_y = [from[1], to[1]].map((y) => value(shown.y, 1 - (y - top) / height)).sort((a, b) => a - b);
          bounded('x', ...at_x);
          bounded('y', ...at_y);
          redraw();
        }
      };
      picture.addEventListener('pointerup', drop);
      picture.addEventListener('pointercancel', drop);

      const tools = document.createElement('div');
      tools.className = 'tools';
      if (reading.series.length > 1) {
        reading.series.forEach((series, index) => {
          const box = document.createElement('label'), input = document.createElement('input');
          input.type = 'checkbox';
          input.checked = !hidden.has(index);
          const apply = () => picture.querySelectorAll('g.s' + index).forEach((layer) => { layer.style.display = input.checked ? '' : 'none'; });
          input.addEventListener('change', () => { hidden[input.checked ? 'delete' : 'add'](index); apply(); keep(); });
          if (!input.checked) apply();
          box.append(input, ' ', series.name);
          tools.append(box);
        });
      }
      const button = (text, act) => {
        const element = document.createElement('button');
        element.type = 'button';
        element.textContent = text;
        element.addEventListener('click', act);
        return element;
      };
      const save = (name, type, text) => {
        const link = document.createElement('a');
        link.href = URL.createObjectURL(new Blob([text], { type }));
        link.download = name;
        link.click();
        URL.revokeObjectURL(link.href);
      };
      const reset = button('Reset zoom', restore);
      reset.hidden = true;
      if (reading.units) {
        const choice = document.createElement('select');
        choice.setAttribute('aria-label', 'unit of the deviation');
        for (const [name, factor] of reading.units) choice.append(new Option(name, factor));
        const chosen = () => { unit = { name: choice.selectedOptions[0].text, factor: +choice.value }; };
        choice.addEventListener('change', () => { chosen(); redraw(); show(at); });
        const known = [...choice.options].findIndex((option) => option.text === before.unit);
        if (known > 0) { choice.selectedIndex = known; chosen(); }
        tools.append(choice);
      }
      tools.append(button('Enlarge', () => { figure.classList.toggle('enlarged'); keep(); show(at); }));
      // the figure with its style in itself: light and this many times as large on paper, or as it is
      const { width: wide, height: high } = picture.viewBox.baseVal;
      const alone = (times) => {
        const copy = picture.cloneNode(true), rules = [...document.styleSheets].flatMap((sheet) => [...sheet.cssRules]);
        copy.setAttribute('xmlns', 'http://www.w3.org/2000/svg');
        copy.style.fontFamily = getComputedStyle(picture).fontFamily;
        if (times) {
          Object.assign(copy.style, { width: times * wide + 'px', height: times * high + 'px' });
          // lines of data do not grow by themselves
          for (const line of copy.querySelectorAll('.data .l')) for (const name of ['stroke-width', 'stroke-dasharray']) {
            const lengths = line.getAttribute(name);
            if (lengths) line.setAttribute(name, lengths.split(' ').map((length) => times * length).join(' '));
          }
        }
        const kept = rules.filter((rule) => !(times && rule.conditionText?.includes('dark')));
        copy.prepend(Object.assign(svg('style', {}), { textContent: kept.map((rule) => rule.cssText).join('\n') }));
        return new XMLSerializer().serializeToString(copy);
      };
      tools.append(button('SVG', () => save(reading.id + '.svg', 'image/svg+xml', alone())));
      tools.append(button('Save PNG', async () => {
        const times = 3, image = new Image();
        const canvas = Object.assign(document.createElement('canvas'), { width: times * wide, height: times * high });
        image.src = 'data:image/svg+xml,' + encodeURIComponent(alone(times));
        await image.decode();
        canvas.getContext('2d').drawImage(image, 0, 0, canvas.width, canvas.height);
        canvas.toBlob((png) => save(reading.id + '.png', 'image/png', png));
      }));
      tools.append(button('CSV', () => {
        const rows = [['series', reading.x.name + ' ' + reading.x.unit, reading.y.name + ' ' + unit.name, 'lower', 'upper'].join(',')];
        for (const series of reading.series) series.x.forEach((x, i) => {
          const reach = (series.reach && series.reach[i]) || ['', ''];
          rows.push([series.name, x, series.y[i] * unit.factor, ...reach.map((end) => end === '' ? '' : end * unit.factor)].join(','));
        });
        save(reading.id + '.csv', 'text/csv', rows.join('\n') + '\n');
      }));
      tools.append(reset);
      figure.append(tools);
      figure.classList.toggle('enlarged', before.enlarged);
      if (before.zoomed) for (const name of ['x', 'y']) bounded(name, before.zoomed[name].from, before.zoomed[name].to);
      if (before.zoomed || unit.factor !== 1) redraw();
      alive += 1;
    }
    return alive;
  };

  // Makes the tables below this element alive.
  const tables = (root) => {
    // each table can be taken along as Markdown
    // which needs a page that nothing could have changed on its way
    for (const table of navigator.clipboard ? root.querySelectorAll('table') : []) {
      const copy = document.createElement('button');
      copy.type = 'button';
      copy.className = 'copy';
      copy.textContent = 'Copy as Markdown';
      copy.addEventListener('click', () => {
        const rows = [...table.rows].map((row) => [...row.cells].flatMap((cell) => [cell.innerText.replace(/\s+/g, ' ').trim(), ...Array(cell.colSpan - 1).fill('')]));
        const lines = rows.map((cells) => '| ' + cells.join(' | ') + ' |');
        lines.splice(1, 0, '|' + ' --- |'.repeat(rows[0].length));
        navigator.clipboard.writeText(lines.join('\n') + '\n').then(() => { copy.textContent = 'Copied'; }, () => { copy.textContent = 'Not allowed'; });
      });
      table.closest('.scroll')?.after(copy);
    }
    for (const scroll of root.querySelectorAll('.scroll, pre')) if (scroll.scrollWidth > scroll.clientWidth) scroll.tabIndex = 0;
  };
  return { enliven, tables };
})();
// paper has no triangle to click on
window.addEventListener('beforeprint', () => document.querySelectorAll('details').forEach((details) => { details.open = true; }));
if (!document.documentElement.dataset.version) {
  // a report
  const alive = vn100.enliven(document);
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
  document.documentElement.dataset.ready = String(alive);
} else {
  // a live page: puts the parts that the program draws in their places, and says when it is out of reach
  const page = document.documentElement;
  const connection = document.getElementById('connection'), announced = document.getElementById('announced');
  const say = (text, lost) => {
    if (connection.textContent !== text) connection.textContent = text;
    // a screen reader says that something is lost or found, and not every second of it
    if (connection.className !== (lost ? 'lost' : '')) announced.textContent = text;
    connection.className = lost ? 'lost' : '';
  };
  const enliven = (element) => {
    vn100.enliven(element);
    vn100.tables(element);
  };
  const waiting = new Map();
  const put = (element, html) => {
    const open = [...element.querySelectorAll('details[open] > summary')].map((summary) => summary.textContent);
    element.innerHTML = html;
    for (const summary of element.querySelectorAll('details > summary')) if (open.includes(summary.textContent)) summary.parentNode.open = true;
    enliven(element);
  };
  // what is read by keyboard stands still until the focus has left it
  document.addEventListener('focusout', () => setTimeout(() => {
    for (const [element, html] of waiting) if (!element.contains(document.activeElement)) { waiting.delete(element); put(element, html); }
  }));
  const take = (id, html) => {
    const element = document.getElementById(id);
    if (!element) return;
    if (element.contains(document.activeElement)) waiting.set(element, html);
    else put(element, html);
  };
  let count = 0;
  let source;
  // what the page knows of the program, when it heard from it last, and when it asked last
  let state = 'waiting', heard = Date.now(), asked = heard;
  const time = () => new Date(heard).toLocaleString();
  // by the reader's own clock: a program that stands still says nothing
  const look = () => {
    const age_s = Math.floor((Date.now() - heard) / 1000);
    const old = state === 'ended' || state === 'lost' || Date.now() - heard > (state === 'full' ? 15000 : 5000);
    page.classList.toggle('old', old);
    if (state === 'ended') say('The program has ended; this is its last state, of ' + time() + '. The page continues when it starts again.', true);
    else if (old) say('No news from the program for ' + age_s + ' s: this is its state of ' + time() + '. Trying again.', true);
    else if (state === 'full') say('Other pages take all streams: this one asks every 5 s. State of ' + time(), false);
    else if (state === 'up') say('Up to date: ' + time(), false);
    // a refusal is final for the browser, and it does not notice that a connection leads nowhere
    const patience_ms = source.readyState === EventSource.CLOSED ? 3000 : 10000;
    if (old && !document.hidden && Date.now() - Math.max(heard, asked) > patience_ms) connect();
  };
  const hear = (now) => { state = now; heard = Date.now(); look(); };
  setInterval(look, 1000);
  const connect = () => {
    source?.close();
    asked = Date.now();
    source = new EventSource('events?page=' + (+location.pathname.slice(1) || 0) + '&since=' + encodeURIComponent(page.dataset.version));
    const isUp = () => { if (state !== 'full') hear('up'); };
    source.addEventListener('alive', () => hear('up'));
    source.addEventListener('snapshot', (event) => {
      const cut = event.data.indexOf('\n');
      take(event.data.slice(0, cut), event.data.slice(cut + 1));
      // of the last event of a state that is whole
      if (event.lastEventId) page.dataset.version = event.lastEventId;
      page.dataset.count = String(count += 1);
      isUp();
    });
    // another run of the program: it may have other sources
    source.addEventListener('other', () => location.reload());
    source.addEventListener('full', () => hear('full'));
    source.addEventListener('end', () => { heard = Date.now(); state = 'ended'; look(); });
    source.addEventListener('error', () => {
      // of a stream that ends as it should, the browser asks again by itself
      if (state === 'up' || state === 'waiting') { state = 'lost'; look(); }
    });
  };
  // a browser has few connections for each program: a page that nobody sees leaves its own to others
  document.addEventListener('visibilitychange', () => document.hidden ? source.close() : connect());
  enliven(document);
  connect();
  page.dataset.ready = 'true';
}
