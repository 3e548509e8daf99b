/** What Python put into the page: JSON, with arrays as base64. */
export function read(id) {
  return JSON.parse(document.getElementById(id).textContent);
}

export function bytes(base64) {
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
}

/** Little-endian float32, as on all machines that run browsers. */
export function numbers(base64) {
  return new Float32Array(bytes(base64).buffer);
}

/** Index of the last of the ascending values that is at most x; -1 if there is none. */
export function lastBefore(x, count, value) {
  let low = 0;
  let high = count;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (value(middle) <= x) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

export function color(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
