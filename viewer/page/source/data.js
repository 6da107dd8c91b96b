// What nlg-view left beside the page: scripts that each call nlgReceive once (viewer/data_script.h). A page that was opened from a
// folder may read no files, but it may run scripts.

const waiting = new WeakMap(); // by script

window.nlgReceive = (name, facts, base64) => {
  const binary = atob(base64);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  const arrays = {};
  for (const [array, [kind, first, count]] of Object.entries(facts.arrays)) {
    arrays[array] = new globalThis[kind](bytes.buffer, first, count);
  }
  waiting.get(document.currentScript)?.({ ...facts, ...arrays });
};

// One set of scripts: those beside the page, or of a page that is served (viewer/page_server.h) those with one number.
export class Data {
  constructor(number) {
    this.loaded = new Map();
    this.query = number === undefined ? '' : `?${number}`;
  }

  // The facts and arrays of NAME.js, read once.
  load(name) {
    if (!this.loaded.has(name)) {
      this.loaded.set(name, new Promise((resolve, reject) => {
        const script = document.createElement('script');
        waiting.set(script, resolve);
        script.src = `${name}.js${this.query}`;
        script.onerror = () => {
          this.loaded.delete(name);
          reject(new Error(`${name}.js is not beside this page, or cannot be read`));
        };
        script.onload = () => script.remove();
        document.head.append(script);
      }));
    }
    return this.loaded.get(name);
  }
}
