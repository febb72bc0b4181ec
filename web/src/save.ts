// Files that the server makes while it sends them: any size, so they go to the disk piece by piece and are never whole in memory.
//
//     await saveWhileMade("recordings/run.tfr/frames.zip", "run.zip", (bytes) => show(bytes), signal);
//
// Where a page may write a file (Chromium, on the loopback or by HTTPS), it does, and counts what has arrived. Elsewhere the
// browser downloads it by itself, from a link. A link cannot tell what went wrong, so the server is asked once before, and
// left alone as soon as it begins to send.

interface PickedFile {
  createWritable: () => Promise<WritableStream<Uint8Array>>;
  remove?: () => Promise<void>;
}

declare global {
  interface Window {
    showSaveFilePicker?: ((options: { suggestedName: string }) => Promise<PickedFile>) | undefined;
  }
}

/** `arrived` hears how many bytes there are so far. Throws an Error with one readable line; not when the user has cancelled. */
export async function saveWhileMade(
  url: string,
  name: string,
  arrived: (bytes: number) => void,
  signal: AbortSignal,
): Promise<void> {
  try {
    // Now and not later: a browser asks for a file only just after a click.
    const file = await pickFile(name);
    if (file) await write(file, url, arrived, signal);
    else await handOver(url, name, signal);
  } catch (error) {
    if (signal.aborted || isCancelled(error)) return;
    throw error;
  }
}

/** Null: this browser does not let this page write files. */
async function pickFile(name: string): Promise<PickedFile | null> {
  try {
    return (await window.showSaveFilePicker?.({ suggestedName: name })) ?? null;
  } catch (error) {
    if (isCancelled(error)) throw error;
    return null;
  }
}

async function write(file: PickedFile, url: string, arrived: (bytes: number) => void, signal: AbortSignal) {
  let size = 0;
  const counter = new TransformStream<Uint8Array, Uint8Array>({
    transform(part, next) {
      arrived((size += part.length));
      next.enqueue(part);
    },
  });
  try {
    const body = await ask(url, signal);
    await body.pipeThrough(counter).pipeTo(await file.createWritable(), { signal });
  } catch (error) {
    // Picking made the file; an empty one would look like a recording without pictures.
    await file.remove?.().catch(() => undefined);
    if (error instanceof TypeError) throw new Error("the server stopped before the end; its log says why");
    throw error;
  }
}

async function handOver(url: string, name: string, signal: AbortSignal): Promise<void> {
  const enough = new AbortController();
  await ask(url, AbortSignal.any([signal, enough.signal]));
  enough.abort();
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  link.click();
}

/** The body of a good answer. */
async function ask(url: string, signal: AbortSignal): Promise<ReadableStream<Uint8Array>> {
  const answer = await fetch(url, { signal }).catch((error: unknown) => {
    throw isCancelled(error) ? error : new Error("the server did not answer");
  });
  if (!answer.ok || !answer.body)
    throw new Error((await answer.text()).trim() || `the server answered ${answer.status}`);
  return answer.body;
}

const isCancelled = (error: unknown): boolean => error instanceof DOMException && error.name === "AbortError";
