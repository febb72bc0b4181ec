// A finger that a hand has kept from the camera, and which the camera is to know after all: a second finger means both.

const replayed = new WeakSet<Event>();

/** Presses again where `event` was, for the camera alone. */
export function replay(element: HTMLElement, event: PointerEvent): void {
  const { pointerId, pointerType, clientX, clientY, isPrimary } = event;
  const init = { pointerId, pointerType, clientX, clientY, isPrimary, button: 0, buttons: 1, bubbles: true };
  const again = new PointerEvent("pointerdown", init);
  replayed.add(again);
  element.dispatchEvent(again);
}

/** Whether hands are to leave this event alone. */
export const isReplayed = (event: Event): boolean => replayed.has(event);
