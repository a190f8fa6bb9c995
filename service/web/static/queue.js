// What was sent and is not acknowledged yet, kept on the device (IndexedDB) until it is.

const NAME = "drumtrue";
const STORE = "waiting";
let memory = []; // where the browser keeps nothing: forms are still sent

function open() {
  return new Promise((resolve, reject) => {
    const asked = indexedDB.open(NAME, 1);
    asked.onupgradeneeded = () => asked.result.createObjectStore(STORE, { keyPath: "id" });
    asked.onsuccess = () => resolve(asked.result);
    asked.onerror = () => reject(asked.error);
  });
}

async function run(mode, act) {
  const store = await open();
  try {
    return await new Promise((resolve, reject) => {
      const work = store.transaction(STORE, mode, { durability: "strict" });
      const asked = act(work.objectStore(STORE));
      work.oncomplete = () => resolve(asked.result);
      work.onerror = work.onabort = () => reject(work.error);
    });
  } finally {
    store.close();
  }
}

// All that waits, the oldest first.
export async function waiting() {
  let stored = [];
  try { stored = await run("readonly", (store) => store.getAll()); } catch { /* see memory */ }
  return [...stored, ...memory].sort((a, b) => a.at - b.at);
}

export async function put(item) {
  try { await run("readwrite", (store) => store.put(item)); } catch { memory = [...memory.filter((one) => one.id !== item.id), item]; }
}

export async function remove(item) {
  memory = memory.filter((one) => one.id !== item.id);
  try { await run("readwrite", (store) => store.delete(item.id)); } catch { /* it was in memory */ }
}
