// The live scene in its page: a picture until it is clicked, then the chapter's own `live`, compiled to
// WebAssembly. This script gives it what a window has elsewhere (instruments/draw/window_web.cpp): a canvas to
// draw triangles on, the pointer and the keys, and HTML's own controls.
'use strict';
(() => {
const figure = document.querySelector('figure[data-chapter]');
const root = document.currentScript.src.replace(/[^/]*$/, '');
const picture = figure.querySelector('img');
const still = matchMedia('(prefers-reduced-motion: reduce)'), dark = matchMedia('(prefers-color-scheme: dark)');
const make = (tag, properties, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};
const narrow = 560;

const start = make('button', {className: 'scene-start', type: 'button', textContent: '▶ Run it here'});
const poster = make('div', {className: 'poster'});
picture.replaceWith(poster);
poster.append(picture, start);
poster.onclick = () => open(location.search);
let close = () => {};

/// Opens the scene, with the parameters of an address such as ?rod=0.3&torque=0.
function open(search) {
  close();
  const canvas = make('canvas', {tabIndex: 0});
  canvas.setAttribute('role', 'application');
  canvas.setAttribute('aria-label', `Live scene: ${document.querySelector('h1').textContent}. Space runs and pauses, ` +
    'the right arrow or s takes one step, r goes back to the start, Escape closes. The controls follow.');
  const panel = make('div', {className: 'panel'}), words = make('p', {className: 'words', textContent: 'Loading …'});
  const said = make('p', {className: 'said'}), shut = make('button', {type: 'button', className: 'shut', textContent: 'close'});
  said.setAttribute('aria-live', 'polite');
  const scene = make('div', {className: 'scene'}, canvas, make('div', {className: 'side'}, panel, words, said, shut));
  poster.replaceWith(scene);
  canvas.focus({preventScroll: true});

  let page, request = 0, last = 0, seen = true, program = null;
  const state = figure.scene = {frames: 0, work: 0, lines: []};  // for those who measure
  const tick = (now) => {
    request = 0;
    if (!seen || document.hidden || !program) return (last = 0);
    const wall = last ? (now - last) / 1000 : 0, before = performance.now();
    last = now;
    try { program._frame(wall); } catch (error) { return fail(error); }
    state.frames += 1;
    state.work += (performance.now() - before) / 1000;
    request = requestAnimationFrame(tick);
  };
  const go = () => { request = request || requestAnimationFrame(tick); };
  const watch = new IntersectionObserver(([entry]) => { seen = entry.isIntersecting; go(); });
  watch.observe(canvas);
  document.addEventListener('visibilitychange', go);

  function fail(error) {
    program = null;
    words.textContent = `The scene cannot run here: ${error.message || error}`;
  }
  close = () => {
    close = () => {};
    program = null;
    cancelAnimationFrame(request);
    watch.disconnect();
    document.removeEventListener('visibilitychange', go);
    page?.forget();
    scene.replaceWith(poster);
    start.focus({preventScroll: true});
  };
  shut.onclick = () => close();
  scene.onkeydown = (event) => { if (event.key === 'Escape') close(); };

  // What the program says, line by line: what was done and when, warnings, refusals.
  const lines = () => {
    let bytes = [];
    return (byte) => {
      if (byte !== 10) return byte !== null && bytes.push(byte);
      const line = new TextDecoder().decode(new Uint8Array(bytes));
      bytes = [];
      state.lines.push(line);
      said.textContent = line;
    };
  };
  try { page = screenOf(canvas, panel, words); } catch (error) { return fail(error); }
  page.starts = () => {
    state.ready = true;
    if (!still.matches) page.press(0);  // it runs, as the space bar would make it
  };
  script(root + `scenes/${figure.dataset.chapter}.js`)
    .then(() => window.chapter({page, stdout: lines(), stderr: lines(), print: () => {}, printErr: () => {}}))
    .then((module) => {
      const options = [...new URLSearchParams(search)].map(([name, value]) => `--${name}=${value}`);
      try { module.callMain(['live', ...options]); } catch (error) { if (!state.ready) throw error; }  // main is left by a trap
      if (!state.ready) throw new Error(state.lines.pop());
      program = module;
      go();
    })
    .catch(fail);
}

const scripts = {};
function script(source) {
  return scripts[source] = scripts[source] || new Promise((done, failed) =>
    document.head.append(make('script', {src: source, onload: done, onerror: () => failed(new Error(`no ${source}`))})));
}

// ---------------------------------------------------------------------------------------------------------
// what the program has in place of a window

function screenOf(canvas, panel, words) {
  const state = new Float64Array(12);  // as in window_web.cpp
  const page = {press: (key) => { state[8 + key] += 1; }};

  // The pointer. A finger pulls in the scene, which is the upper part, and scrolls on the plots.
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    state[4] = event.clientX - box.left;
    state[5] = event.clientY - box.top;
  };
  canvas.onpointermove = place;
  canvas.onpointerdown = (event) => {
    if (event.button !== 0) return;
    place(event);
    state[6] = state[7] = 1;
    canvas.setPointerCapture(event.pointerId);
  };
  canvas.onpointerup = canvas.onpointercancel = () => { state[7] = 0; };
  canvas.addEventListener('touchstart', (event) => {
    const box = canvas.getBoundingClientRect();
    if (event.touches.length === 1 && event.touches[0].clientY - box.top < 0.55 * box.height) event.preventDefault();
  }, {passive: false});
  canvas.onkeydown = (event) => {
    const key = [' ', 'ArrowRight', 'r', 's'].indexOf(event.key);
    if (key < 0 || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    if (!event.repeat || key % 2 === 1) page.press(key);
  };

  page.state = () => {
    const width = canvas.clientWidth, scale = window.devicePixelRatio;
    const height = width < narrow ? 620 : Math.round(0.625 * width) + 190;
    if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
      canvas.style.height = `${height}px`;
      canvas.width = Math.round(width * scale);
      canvas.height = Math.round(height * scale);
    }
    state.set([width, height, scale, Number(dark.matches)]);
    const now = state.slice();
    state[6] = 0;
    state.fill(0, 8);
    return now;
  };

  // Triangles, of which each corner has a place [pixels], a place on the texture and a colour.
  const gl = canvas.getContext('webgl2', {antialias: false, alpha: false});
  if (!gl) throw new Error('it needs WebGL 2');
  const compile = (type, text) => {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, `#version 300 es\nprecision highp float;\n${text}`);
    gl.compileShader(shader);
    return shader;
  };
  const shaders = gl.createProgram();
  gl.attachShader(shaders, compile(gl.VERTEX_SHADER, `uniform vec2 size; layout(location = 0) in vec2 at;
    layout(location = 1) in vec2 uv; layout(location = 2) in vec4 ink; out vec2 spot; out vec4 color;
    void main() { spot = uv; color = ink; gl_Position = vec4(2.0 * at.x / size.x - 1.0, 1.0 - 2.0 * at.y / size.y, 0, 1); }`));
  gl.attachShader(shaders, compile(gl.FRAGMENT_SHADER, `uniform sampler2D coverage; in vec2 spot; in vec4 color; out vec4 ink;
    void main() { ink = vec4(color.rgb, color.a * texture(coverage, spot).r); }`));
  gl.linkProgram(shaders);
  gl.useProgram(shaders);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.enable(gl.BLEND);
  gl.enable(gl.SCISSOR_TEST);
  gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  [0, 1, 2].forEach((i) => gl.enableVertexAttribArray(i));
  const size = gl.getUniformLocation(shaders, 'size');
  page.clear = (r, g, b) => {
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.scissor(0, 0, canvas.width, canvas.height);
    gl.clearColor(r / 255, g / 255, b / 255, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.uniform2f(size, canvas.width, canvas.height);
  };
  page.texture = (coverage, width, height) => {
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, width, height, 0, gl.RED, gl.UNSIGNED_BYTE, coverage);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
  };
  page.mesh = (vertices, indices) => {
    gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STREAM_DRAW);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STREAM_DRAW);
  };
  page.fill = (first, count, vertex, left, top, right, bottom) => {
    gl.scissor(left, canvas.height - bottom, right - left, bottom - top);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 20, 20 * vertex);
    gl.vertexAttribPointer(1, 2, gl.FLOAT, false, 20, 20 * vertex + 8);
    gl.vertexAttribPointer(2, 4, gl.UNSIGNED_BYTE, true, 20, 20 * vertex + 16);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_SHORT, 2 * first);
  };
  page.forget = () => gl.getExtension('WEBGL_lose_context')?.loseContext();

  // The controls, each made when it is first asked for. What is asked is answered once.
  const controls = {};
  const control = (key, create) => {
    if (!controls[key]) panel.append((controls[key] = create()).element);
    return controls[key];
  };
  const take = (it, part) => {
    const value = it[part];
    it[part] = false;
    return value;
  };
  const row = (name, ...parts) => make('label', {className: 'row'}, make('span', {textContent: name}), ...parts);
  const enable = (input, enabled) => { if (input.disabled === enabled) input.disabled = !enabled; };
  page.button = (text, where, enabled) => {
    const it = control(`button ${where}`, () => {
      const made = {element: make('button', {type: 'button', onclick: () => { made.clicked = true; }})};
      return made;
    });
    if (it.element.textContent !== text) it.element.textContent = text;
    enable(it.element, enabled);
    return take(it, 'clicked');
  };
  page.check = (name, checked) => {
    const it = control(`check ${name}`, () => {
      const input = make('input', {type: 'checkbox', name: `${name}-on`, oninput: () => { made.toggled = true; }});
      const made = {input, element: make('label', {className: 'check'}, input, ` ${name}`)};
      return made;
    });
    if (take(it, 'toggled')) return it.input.checked !== checked;
    if (it.input.checked !== checked) it.input.checked = checked;
    return false;
  };
  page.slider = (name, value, low, high, log, whole, unit, enabled) => {
    const it = control(`slider ${name}`, () => {
      const rests = () => { made.rests = true; };
      const slide = make('input', {type: 'range', name, min: 0, max: 1000, step: 'any', oninput() { made.slid = true; }, onchange: rests});
      const box = make('input', {type: 'text', inputMode: 'decimal', autocomplete: 'off', onchange() { made.typed = true; }});
      slide.setAttribute('aria-label', `${name}${unit && `, in ${unit}`}`);
      box.setAttribute('aria-label', `${name}, value`);
      const made = {slide, box, element: make('div', {className: 'row'}, make('span', {textContent: name}), slide, box,
        make('span', {className: 'unit', textContent: unit}))};
      return made;
    });
    const {slide, box} = it, [a, b] = log ? [Math.log(low), Math.log(high)] : [low, high];
    enable(slide, enabled);
    enable(box, enabled);
    if (take(it, 'slid')) {
      const at = a + (b - a) * slide.value / 1000;
      value = log ? Math.exp(at) : at;
      if (whole) value = Math.round(value);
    }
    let rests = take(it, 'rests');
    if (take(it, 'typed')) {
      const typed = Number(box.value.replace(',', '.'));
      if (box.value.trim() !== '' && Number.isFinite(typed)) value = typed;
      it.shown = undefined;
      rests = true;
    }
    if (value !== it.shown) {
      it.shown = value;
      const text = String(Number(value.toPrecision(4)));
      if (document.activeElement !== slide || !slide.matches(':active'))
        slide.value = 1000 * ((log ? Math.log(Math.max(value, low)) : value) - a) / (b - a);
      slide.setAttribute('aria-valuetext', `${text} ${unit}`);
      if (document.activeElement !== box || rests) box.value = text;
    }
    return {value, rests};
  };
  page.choice = (name, texts, chosen) => {
    const it = control(`choice ${name}`, () => {
      const select = make('select', {name, onchange: () => { made.picked = true; }},
        ...texts.map((text) => make('option', {textContent: text})));
      const made = {select, element: row(name, select)};
      return made;
    });
    if (take(it, 'picked')) return it.select.selectedIndex;
    if (it.select.selectedIndex !== chosen) it.select.selectedIndex = chosen;
    return chosen;
  };
  page.text = (text, r, g, b) => {
    if (words.textContent !== text) words.textContent = text;
    words.style.color = `rgb(${r} ${g} ${b})`;
  };
  return page;
}

// A link to a state of this scene opens it here; from elsewhere the address does.
document.addEventListener('click', (event) => {
  const link = event.target.closest('a.live');
  if (!link || event.ctrlKey || event.metaKey || event.shiftKey) return;
  event.preventDefault();
  history.pushState(null, '', link.href);
  open(link.search);
  figure.scrollIntoView();
});
if (location.search) open(location.search);
})();
