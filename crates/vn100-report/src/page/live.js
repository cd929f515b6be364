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
  const take = (parts) => {
    for (const [id, html] of Object.entries(parts)) {
      const element = document.getElementById(id);
      if (!element) continue;
      if (element.contains(document.activeElement)) waiting.set(element, html);
      else put(element, html);
    }
  };
  let count = 0;
  const connect = () => {
    const source = new EventSource('events?since=' + encodeURIComponent(page.dataset.version));
    source.addEventListener('snapshot', (event) => {
      take(JSON.parse(event.data));
      // of the last event of a state that is whole
      if (event.lastEventId) page.dataset.version = event.lastEventId;
      page.dataset.count = String(count += 1);
      say('Up to date: ' + new Date().toLocaleTimeString(), false);
    });
    // another run of the program: it may have other sources
    source.addEventListener('other', () => location.reload());
    source.addEventListener('end', () => { page.dataset.ended = 'true'; });
    source.addEventListener('error', () => {
      say(page.dataset.ended ? 'The program has ended; this is its last state. The page continues when it starts again.' : 'The program is out of reach; this is the last state. Trying again.', true);
      // a refusal is final for the browser, and not for this page
      if (source.readyState === EventSource.CLOSED) setTimeout(connect, 3000);
    });
  };
  for (const element of document.querySelectorAll('main [id]')) if (!element.closest('svg')) if (element.querySelector(':scope > script.readings')) vn100.enliven(JSON.parse(element.querySelector(':scope > script.readings').textContent));
  vn100.tables(document);
  connect();
  page.dataset.ready = 'true';
}
