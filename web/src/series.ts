// The last seconds of the simulation's numbers, for plots: columns of equal length, oldest first.
//
//     const series = new Series(400);
//     series.push(state);
//     series.time, series.levels[0], series.phases.solve

import type { Phases, SimulationState } from "./messages";

export const PHASES: readonly (keyof Phases)[] = ["adapt", "setup", "assemble", "solve", "other"];
const SECONDS = 20;

export class Series {
  time: number[] = []; // [s] simulated
  levels: number[][] = []; // [depth+1] tets
  phases: number[][] = PHASES.map(() => []); // [ms]; without phases, all is "other"
  estimate: number[] = []; // [%]
  tolerance: number[] = [];
  kinetic: (number | null)[] = []; // [J]
  elastic: (number | null)[] = [];

  /** False when nothing is new. A reset, or another scene, starts over. */
  push(state: SimulationState): boolean {
    const last = this.time.at(-1);
    if (last !== undefined && (state.time < last || state.tets_by_level.length !== this.levels.length)) this.clear();
    else if (state.time === last) return false;
    if (this.levels.length === 0) this.levels = state.tets_by_level.map(() => []);
    this.time.push(state.time);
    state.tets_by_level.forEach((tets, level) => this.levels[level].push(tets));
    PHASES.forEach((phase, i) =>
      this.phases[i].push(state.phases ? state.phases[phase] : phase === "other" ? state.milliseconds : 0),
    );
    this.estimate.push(100 * state.estimate);
    this.tolerance.push(100 * state.tolerance);
    this.kinetic.push(state.energy?.kinetic ?? null);
    this.elastic.push(state.energy?.elastic ?? null);
    let old = 0;
    while (old < this.time.length - 2 && state.time - this.time[old] > SECONDS) ++old;
    if (old) for (const column of this.columns()) column.splice(0, old);
    return true;
  }

  clear(): void {
    for (const column of this.columns()) column.length = 0;
    this.levels = [];
  }

  private columns(): unknown[][] {
    return [this.time, ...this.levels, ...this.phases, this.estimate, this.tolerance, this.kinetic, this.elastic];
  }
}

/** Sums of the first 1, 2, 3 ... columns: what a stacked plot draws, the last on top. */
export function stack(columns: readonly (readonly number[])[]): number[][] {
  let below: number[] | null = null;
  return columns.map((column) => {
    const sum: number[] = column.map((value, i) => value + (below?.[i] ?? 0));
    below = sum;
    return sum;
  });
}
