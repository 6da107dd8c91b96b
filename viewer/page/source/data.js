// What nlg-view left beside the page: scripts that each call nlgReceive once (viewer/data_script.h). A page that was opened from a
// folder may read no files, but it may run scripts.

const waiting = new Map();

window.nlgReceive = (name, facts, base64) => {
  const binary = atob(base64);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  const arrays = {};
  for (const [array, [kind, first, count]] of Object.entries(facts.arrays)) {
    arrays[array] = new globalThis[kind](bytes.buffer, first, count);
  }
  waiting.get(name)?.({ ...facts, ...arrays });
};

const loaded = new Map();

// The facts and arrays of NAME.js, read once.
export function load(name) {
  if (!loaded.has(name)) {
    loaded.set(name, new Promise((resolve, reject) => {
      waiting.set(name, resolve);
      const script = document.createElement('script');
      script.src = `${name}.js`;
      script.onerror = () => {
        loaded.delete(name);
        reject(new Error(`${name}.js is not beside this page, or cannot be read`));
      };
      script.onload = () => script.remove();
      document.head.append(script);
    }));
  }
  return loaded.get(name);
}
