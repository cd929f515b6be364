// Measures files with the instrument, which reads them through this worker.
'use strict';
const reader = new FileReaderSync();
let instrument, file, told = 0;

// a port without a partner frees at once what is given to it: nothing is collected while the instrument runs
const { port1: freed, port2: partner } = new MessageChannel();
partner.close();

const page = {
  read_file(offset, to, length) {
    try {
      const buffer = reader.readAsArrayBuffer(file.slice(offset, offset + length));
      const count = buffer.byteLength;
      new Uint8Array(instrument.memory.buffer, to, length).set(new Uint8Array(buffer));
      freed.postMessage(null, [buffer]);
      return count;
    } catch {
      // the file was removed, or changed since it was chosen
      return -1;
    }
  },
  progress(bytes) {
    const now = Date.now();
    if (now - told < 100) return;
    told = now;
    postMessage({ type: 'progress', bytes });
  },
};

const answer = (length) => new TextDecoder().decode(new Uint8Array(instrument.memory.buffer, instrument.answer(), length));
const ask = (text) => {
  const bytes = new TextEncoder().encode(text);
  // before its memory is looked at, which may move
  const to = instrument.request(bytes.length);
  new Uint8Array(instrument.memory.buffer, to, bytes.length).set(bytes);
};
// the answer of the library, or its error in words
const measured = (length) => {
  const found = JSON.parse(answer(length));
  if (found.Err !== undefined) throw new Error(found.Err);
  return found.Ok;
};

const tasks = {
  async start({ bytes }) {
    ({ instance: { exports: instrument } } = await WebAssembly.instantiate(bytes, { page }));
  },
  clear() { instrument.clear(); },
  measure(task) {
    file = task.file;
    ask(JSON.stringify(task.request));
    return measured(instrument.measure(file.size));
  },
  sample() { return measured(instrument.measure_sample()); },
  outputs({ fills }) { return JSON.parse(answer(instrument.outputs(fills ? 1 : 0))); },
  output({ file: name }) {
    ask(name);
    return answer(instrument.output());
  },
};

// one after the other
let before = Promise.resolve();
onmessage = ({ data }) => {
  before = before.then(async () => {
    try {
      postMessage({ id: data.id, value: await tasks[data.type](data) });
    } catch (error) {
      const broken = error instanceof WebAssembly.RuntimeError || error instanceof RangeError;
      postMessage({ id: data.id, broken, error: error.message });
    }
  });
};
