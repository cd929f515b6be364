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
  const details = [...document.querySelectorAll('details.source')];
  const connect = (since) => {
    clearTimeout(again);
    // the details of those that are open alone
    const open = details.filter((one) => one.open).map((one) => one.dataset.source).join(',');
    source = new EventSource('events?since=' + encodeURIComponent(since) + '&open=' + encodeURIComponent(open));
    const isUp = () => say('Up to date: ' + new Date().toLocaleTimeString(), false);
    // where nothing changes, no event follows
    source.addEventListener('open', isUp);
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
    source.addEventListener('end', () => { page.dataset.ended = 'true'; });
    source.addEventListener('error', () => {
      say(page.dataset.ended ? 'The program has ended; this is its last state. The page continues when it starts again.' : 'The program is out of reach; this is the last state. Trying again.', true);
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
