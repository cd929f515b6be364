// Puts the parts that the program draws in their places, and says when it is out of reach.
{
  const page = document.documentElement;
  const connection = document.getElementById('connection');
  const say = (text, lost) => {
    if (connection.textContent !== text) connection.textContent = text;
    connection.className = lost ? 'lost' : '';
  };
  const enliven = (element) => {
    const readings = element.querySelector('script.readings');
    if (readings) vn100.enliven(JSON.parse(readings.textContent));
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
  let source, again;
  // what the page knows of the program, and when it heard from it last
  let state = 'waiting', heard = Date.now(), limit_ms = 5000;
  const details = [...document.querySelectorAll('details.source')];
  const time = () => new Date(heard).toLocaleTimeString();
  // by the reader's own clock: a program that stands still says nothing
  const look = () => {
    const age_s = Math.floor((Date.now() - heard) / 1000);
    const old = state === 'ended' || state === 'lost' || Date.now() - heard > limit_ms;
    page.classList.toggle('old', old);
    if (state === 'ended') say('The program has ended; this is its last state, of ' + time() + '. The page continues when it starts again.', true);
    else if (old) say('No news from the program for ' + age_s + ' s: this is its state of ' + time() + '. Trying again.', true);
    else if (state === 'full') say('Other pages take all streams: this one asks every 5 s. State of ' + time(), false);
    else if (state === 'up') say('Up to date: ' + time(), false);
  };
  const hear = (now) => { state = now; heard = Date.now(); look(); };
  setInterval(look, 1000);
  const connect = (since) => {
    clearTimeout(again);
    // the details of those that are open alone
    const open = details.filter((one) => one.open).map((one) => one.dataset.source).join(',');
    source = new EventSource('events?since=' + encodeURIComponent(since) + '&open=' + encodeURIComponent(open));
    const isUp = () => { if (state !== 'full') hear('up'); };
    source.addEventListener('alive', () => { limit_ms = 5000; hear('up'); });
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
    source.addEventListener('full', () => { limit_ms = 15000; hear('full'); });
    source.addEventListener('end', () => { heard = Date.now(); state = 'ended'; look(); });
    source.addEventListener('error', () => {
      // of a stream that ends as it should, the browser asks again by itself
      if (state === 'up' || state === 'waiting') { state = 'lost'; look(); }
      // a refusal is final for the browser, and not for this page
      if (source.readyState === EventSource.CLOSED) again = setTimeout(() => connect(page.dataset.version), 3000);
    });
  };
  // all anew: what has been opened was not sent before
  for (const one of details) one.addEventListener('toggle', () => { source.close(); connect(''); });
  for (const element of document.querySelectorAll('main [id]')) if (!element.closest('svg')) if (element.querySelector(':scope > script.readings')) vn100.enliven(JSON.parse(element.querySelector(':scope > script.readings').textContent));
  vn100.tables(document);
  // the page came without the details
  connect(details.some((one) => one.open) ? '' : page.dataset.version);
  page.dataset.ready = 'true';
}
