// Numbers for people: few digits, SI prefixes, a real minus sign.

const PREFIXES = ["", "k", "M", "G", "T"];

/** 1234567 Pa -> "1.23 MPa"; three significant digits. Small values keep the plain unit. */
export function quantity(value: number, unit: string): string {
  if (!Number.isFinite(value)) return "–";
  let scaled = Math.abs(value);
  let prefix = 0;
  while (scaled >= 999.5 && prefix < PREFIXES.length - 1) {
    scaled /= 1000;
    ++prefix;
  }
  return `${value < 0 ? "−" : ""}${significant(scaled)} ${PREFIXES[prefix]}${unit}`;
}

/** Three significant digits without trailing zeros: 0.0123, 12.3, 123; very small ones as 1.2e−5. */
export function significant(value: number, digits = 3): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  if (Math.abs(value) < 1e-3) return value.toExponential(digits - 2).replace(/-/g, "−");
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

/** 0.0123 -> "1.23 %" */
export const percent = (value: number): string => (Number.isFinite(value) ? `${significant(100 * value, 2)} %` : "–");

/** 12345 -> "12 345" with narrow spaces that do not break. */
export const count = (value: number): string =>
  Number.isFinite(value) ? String(Math.round(value)).replace(/\B(?=(\d{3})+(?!\d))/g, "\u202f") : "–";

/** Simulated time: 3.25 s, 2 min 5.0 s. */
export function duration(seconds: number): string {
  if (!Number.isFinite(seconds)) return "–";
  if (seconds < 60) return `${seconds.toFixed(2)} s`;
  return `${Math.floor(seconds / 60)} min ${(seconds % 60).toFixed(1)} s`;
}

/** Simulated time where there is little room: 3.25 s, 2:05.0. */
export function clock(seconds: number): string {
  if (!(seconds >= 60)) return duration(seconds);
  return `${Math.floor(seconds / 60)}:${(seconds % 60).toFixed(1).padStart(4, "0")}`;
}

/** 0.002 -> 2 mm, 0.05 -> 5 cm, 2 -> 2 m */
export function quantityOfLength(metres: number): string {
  if (metres < 0.0099) return quantity(1000 * metres, "mm");
  return metres < 0.99 ? quantity(100 * metres, "cm") : quantity(metres, "m");
}

/** 1234567 -> "1.23 MB" */
export const bytes = (size: number): string => quantity(size, "B");
