'use strict';
const by = (id) => document.getElementById(id);
const form = by('form'), field = (name) => form.elements[name];

// the instrument in its worker; a new one after a cancellation or a fault
let worker, waiting, onProgress = () => {};
let count = 0;
const instrument = (async () => {
  const packed = Uint8Array.from(atob(by('instrument').textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream).arrayBuffer();
})();
const start = async () => {
  const url = URL.createObjectURL(new Blob([by('worker').textContent], { type: 'text/javascript' }));
  worker = new Worker(url);
  waiting = new Map();
  worker.onmessage = ({ data }) => {
    if (data.type === 'progress') return onProgress(data.bytes);
    const { resolve, reject } = waiting.get(data.id);
    waiting.delete(data.id);
    if (data.error === undefined) resolve(data.value);
    else reject(Object.assign(new Error(data.error), { broken: data.broken }));
  };
  await ask('start', { bytes: await instrument });
};
const ask = (type, data) => new Promise((resolve, reject) => {
  const id = count++;
  waiting.set(id, { resolve, reject });
  worker.postMessage({ ...data, type, id });
});
const stop = () => {
  worker.terminate();
  for (const { reject } of waiting.values()) reject(Object.assign(new Error('Cancelled.'), { cancelled: true }));
  return start();
};
let ready = start();

// what is measured: files, or the sample
let chosen = null;
const size = (bytes) => bytes < 1e6 ? `${Math.ceil(bytes / 1e3)} kB` : bytes < 1e9 ? `${(bytes / 1e6).toFixed(1)} MB` : `${(bytes / 1e9).toFixed(2)} GB`;
const number = (name) => field(name).value.trim() === '' ? null : Number(field(name).value);
const text = (name) => field(name).value.trim() || null;
const request = (file) => ({
  name: file.name,
  rate_hz: number('rate_hz'),
  window: number('window'),
  topic: text('topic'),
  columns: text('columns'),
  compensated: text('compensated') === null ? null : field('compensated').value === 'true',
  skip_s: number('skip_s'),
  duration_s: number('duration_s'),
  datasheet: text('datasheet'),
  accept_unchecked: field('accept_unchecked').checked,
});

const problem = (text, kind = 'problem') => {
  const line = document.createElement('p');
  line.className = `warning ${kind}`;
  line.textContent = text;
  by('problems').append(line);
};

// what the user can say so that a file can be read: the field, with a guess in it
const offer = ({ field: name, guess, choices }) => {
  const input = field({ rate: 'rate_hz' }[name] || name);
  by('options').open = true;
  if (guess && !input.value) input.value = input.dataset.guess = guess;
  by('topics').replaceChildren(...choices.map((choice) => Object.assign(document.createElement('option'), { value: choice })));
  input.classList.add('asked');
  input.focus();
};

const measureAll = async () => {
  by('problems').replaceChildren();
  for (const input of form.querySelectorAll('.asked')) input.classList.remove('asked');
  by('result').hidden = true;
  by('work').hidden = false;
  document.body.classList.remove('start');
  by('again').disabled = true;
  const progress = by('progress');
  try {
    await ready;
    await ask('clear');
    let answers = [];
    if (chosen === 'sample') {
      by('doing').textContent = 'Measuring an hour of the emulated sensor';
      progress.removeAttribute('value');
      answers = await ask('sample');
    } else {
      for (const [index, file] of chosen.entries()) {
        const which = chosen.length > 1 ? ` (${index + 1} of ${chosen.length})` : '';
        by('doing').textContent = `Reading ${file.name}${which}, ${size(file.size)}`;
        progress.removeAttribute('value');
        onProgress = (bytes) => { progress.value = Math.min(bytes / file.size, 1); };
        answers.push(...await ask('measure', { file, request: request(file) }));
      }
    }
    by('doing').textContent = 'Drawing the report';
    progress.removeAttribute('value');
    for (const { error } of answers) if (error) problem(error);
    const cure = answers.find((answer) => answer.cure);
    if (cure) offer(cure.cure);
    await show();
  } catch (error) {
    if (error.broken) {
      problem('The instrument stopped on this file, as by a lack of memory. The program vn100 reads it with the memory of the machine.');
      ready = stop();
    } else {
      problem(error.message, error.cancelled ? 'note' : 'problem');
    }
  }
  by('work').hidden = true;
  by('again').disabled = !chosen;
};

// the report, and the forms in which it can be saved
let outputs = [];
const list = async () => {
  outputs = await ask('outputs', { fills: by('fills').checked });
  const select = by('outputs'), before = select.value;
  select.replaceChildren();
  for (const group of new Set(outputs.map((output) => output.group))) {
    const part = Object.assign(document.createElement('optgroup'), { label: group });
    for (const output of outputs.filter((output) => output.group === group)) {
      const label = output.missing ? `${output.label} (not known)` : output.label;
      part.append(Object.assign(document.createElement('option'), { value: output.file, textContent: label }));
    }
    select.append(part);
  }
  if (outputs.some((output) => output.file === before)) select.value = before;
  choose();
};
const selected = () => outputs.find((output) => output.file === by('outputs').value);
const choose = () => {
  const output = selected();
  by('save').disabled = !output || !!output.missing;
  by('missing').textContent = output && output.missing || '';
};
// what is dropped on the report goes to this page
const DROPS = `<script>
for (const name of ['dragover', 'drop']) addEventListener(name, (event) => {
  event.preventDefault();
  if (name === 'drop') parent.postMessage([...event.dataTransfer.files], '*');
});
</`+`script>`;
const show = async () => {
  await list();
  const page = outputs.length ? await ask('output', { file: outputs[0].file }) : '';
  by('result').hidden = !page;
  by('report').srcdoc = page && page.replace('</body>', () => `${DROPS}</body>`);
};
const save = (name, content, type) => {
  const url = URL.createObjectURL(new Blob([content], { type }));
  Object.assign(document.createElement('a'), { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60000);
};
const TYPES = { html: 'text/html', json: 'application/json', csv: 'text/csv' };
const content = () => ask('output', { file: selected().file });
by('save').addEventListener('click', async () => {
  const { file } = selected();
  save(file, await content(), TYPES[file.split('.').pop()] || 'text/plain');
});
by('alone').addEventListener('click', async () => {
  const page = await ask('output', { file: outputs[0].file });
  window.open(URL.createObjectURL(new Blob([page], { type: 'text/html' })));
});
by('outputs').addEventListener('change', choose);
by('fills').addEventListener('change', list);

// one measurement at a time: another one ends it
let before = Promise.resolve();
const begin = (what) => {
  if (!by('work').hidden) ready = stop();
  before = before.then(() => {
    chosen = what;
    return measureAll();
  });
};
// a guess is for the files before, unless the user has changed it
const forget = () => {
  for (const input of form.querySelectorAll('[data-guess]')) {
    if (input.value === input.dataset.guess) input.value = '';
    delete input.dataset.guess;
  }
};
const take = (files) => {
  if (!files.length) return;
  forget();
  begin([...files]);
};
// so that the same file can be chosen again
by('files').addEventListener('click', ({ target }) => { target.value = ''; });
by('files').addEventListener('change', ({ target }) => take(target.files));
by('sample').addEventListener('click', () => { forget(); begin('sample'); });
by('cancel').addEventListener('click', () => { ready = stop(); by('files').focus(); });
form.addEventListener('submit', (event) => { event.preventDefault(); if (chosen) begin(chosen); });
addEventListener('message', ({ source, data }) => {
  const areFiles = Array.isArray(data) && data.every((file) => file instanceof File);
  if (areFiles && source === by('report').contentWindow) take(data);
});
// a frame prints only what is seen of it: on paper its content stands in the page
addEventListener('beforeprint', () => {
  by('paper').replaceChildren(...new DOMParser().parseFromString(by('report').srcdoc, 'text/html').body.childNodes);
  for (const part of by('paper').querySelectorAll('details')) part.open = true;
});
addEventListener('afterprint', () => by('paper').replaceChildren());
// a drop anywhere on the page counts
for (const name of ['dragover', 'dragleave', 'drop']) {
  document.addEventListener(name, (event) => {
    event.preventDefault();
    by('drop').classList.toggle('over', name === 'dragover');
    if (name === 'drop') take(event.dataTransfer.files);
  });
}
