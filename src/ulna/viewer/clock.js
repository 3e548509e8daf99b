/** The time of a run, s: played over and over at some speed, or set. */
export class Clock {
  /** Whoever is told of each new time. */
  listeners = [];
  playing = false;
  speed = 1;

  constructor(start, end) {
    this.start = start;
    this.end = end;
    this.time = start;
  }

  /** Sets the time, within the run. */
  seek(time) {
    this.time = Math.min(Math.max(time, this.start), this.end);
    this.tell();
  }

  play() {
    if (this.playing || this.end <= this.start) return;
    this.playing = true;
    this.last = undefined;
    this.tell();
    requestAnimationFrame((now) => this.advance(now));
  }

  pause() {
    this.playing = false;
    this.tell();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  advance(now) {
    if (!this.playing) return;
    // a page that was hidden goes on where it was
    const passed = this.last === undefined ? 0 : Math.min((now - this.last) / 1000, 0.5);
    this.last = now;
    const time = this.time + passed * this.speed;
    this.seek(time > this.end ? this.start : time);
    requestAnimationFrame((later) => this.advance(later));
  }

  tell() {
    for (const listener of this.listeners) listener(this);
  }
}
