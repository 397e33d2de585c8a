// A chapter of the book in headless Chromium, as a reader meets it:
//
//   node scene_test.js CHROMIUM MAKER BOOK CHAPTER [FOLDER]
//
// MAKER is the folder of serve.js, BOOK what pages.js made. With a FOLDER screenshots of the page go there, at three
// widths, light and dark.
'use strict';
const assert = require('assert');
const fs = require('fs');
const path = require('path');
const {launch} = require('./chromium.js');

const [program, maker, out, chapter, pictures] = process.argv.slice(2);
const {serve} = require(path.join(maker, 'serve.js'));

/// The last line that the scene said and that matches; the page waits for it.
async function said(page, pattern) {
  const lines = `(document.querySelector('[data-chapter]').scene?.lines || [])`;
  await page.until(`${lines}.some((line) => ${pattern}.test(line))`);
  return page.ask(`${lines}.filter((line) => ${pattern}.test(line)).pop()`);
}
const frames = (page) => page.ask(`document.querySelector('[data-chapter]').scene.frames`);
const canvas = (page) => page.ask(`(({left, top, width, height}) => ({left, top, width, height}))(
  document.querySelector('canvas').getBoundingClientRect())`);
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const click = (page, selector) => page.ask(`document.querySelector('${selector}').click()`);
const pressed = (page, text) => page.ask(`[...document.querySelectorAll('.panel button')].find((one) => one.textContent === '${text}').click()`);
const set = (page, selector, value, ...events) => page.ask(`(() => { const input = document.querySelector('${selector}');
  input.value = ${JSON.stringify(value)}; ${events.map((event) => `input.dispatchEvent(new Event('${event}'));`).join(' ')} })()`);
const timeOf = (line) => Number(/t = ([\d.e+-]+) s/.exec(line)[1]);

async function everyChapter(page, url) {
  await page.size(1000, 800);
  await page.go(url);
  assert(await page.ask(`!document.querySelector('canvas') && !!document.querySelector('.poster img')`), 'a picture first');
  // Enter on its button starts it, and it runs.
  await page.ask(`document.querySelector('.scene-start').focus()`);
  const before = Date.now();
  await page.key('Enter');
  await said(page, /^runs at t = 0 s/);
  await page.until(`document.querySelector('[data-chapter]').scene.frames > 2`);
  console.log(`${chapter}: live after ${((Date.now() - before) / 1000).toFixed(2)} s`);
  await pause(1500);
  const {count, work} = await page.ask(`(({frames, work}) => ({count: frames, work}))(document.querySelector('[data-chapter]').scene)`);
  console.log(`${chapter}: ${count} frames of ${(1000 * work / count).toFixed(2)} ms`);
  await pressed(page, 'pause');
  const stood = timeOf(await said(page, /^paused at t/));
  assert(stood > 0, 'time went on');
  await pressed(page, 'step');
  assert(timeOf(await said(page, /^step at t/)) > stood, 'one step');
  // The wheel scrolls the page, and out of sight no frame is drawn.
  const box = await canvas(page);
  await page.ask('scrollTo(0, 0)');
  await page.send('Input.dispatchMouseEvent', {type: 'mouseWheel', x: box.left + 50, y: 300, deltaX: 0, deltaY: 200});
  await page.until('scrollY > 0');
  await page.ask('scrollTo({top: document.body.scrollHeight, behavior: "instant"})');
  await pause(300);
  const hidden = await frames(page);
  await pause(500);
  assert((await frames(page)) - hidden <= 1, 'it pauses out of sight');
  await page.ask(`document.querySelector('canvas').scrollIntoView({behavior: 'instant'})`);
  await page.until(`document.querySelector('[data-chapter]').scene.frames > ${hidden + 1}`);
  // Tab leaves the canvas, Escape closes the scene.
  await page.ask(`document.querySelector('canvas').focus()`);
  await page.key(' ', 'Space');
  await page.until(`document.querySelector('[data-chapter]').scene.lines.filter((line) => line.startsWith('runs')).length === 2`);
  await page.key('Tab');
  assert.strictEqual(await page.ask('document.activeElement.tagName'), 'BUTTON', 'Tab goes on to the controls');
  await page.key('Escape');
  await page.until(`!document.querySelector('canvas') && !!document.querySelector('.poster img')`);
  assert(await page.ask(`document.activeElement.className === 'scene-start'`), 'back to its picture');
  // Each state that the lesson links to opens, or says why the program refuses it, in a lesson on a refusal.
  const links = await page.ask(`[...document.querySelectorAll('a.live')].map((link) => link.search)`);
  for (const link of new Set(links)) {
    await page.ask(`[...document.querySelectorAll('a.live')].find((one) => one.search === ${JSON.stringify(link)}).click()`);
    const refused = /ease=linear/.test(link);
    if (refused) await page.until(`/infinite force/.test(document.querySelector('.words')?.textContent)`);
    else await said(page, /^runs at t = 0 s/);
    if (!refused) await page.until(`document.querySelector('[data-chapter]').scene.frames > 0`);
  }
  assert(await page.ask(`[...document.querySelectorAll('h2')].some((one) => one.textContent === 'Turn it off') &&
    document.querySelectorAll('h2#turn-it-off ~ * a.live').length > 0`), 'what is turned off is linked to');
  // What cannot be is said.
  await page.go(`${url}?dance=1`);
  await page.until(`/dance/.test(document.querySelector('.words')?.textContent)`);
}

async function sliderCrank(page, url) {
  await page.size(1000, 900, 2);
  await page.go(`${url}?rod=0.9&torque=1`);
  await said(page, /^runs at t = 0 s/);
  await page.until(`document.querySelector('input[name=torque]')?.getAttribute('aria-valuetext') === '1 N·m'`);
  assert(/^0.9 m/.test(await page.ask(`document.querySelector('input[name=rod]').getAttribute('aria-valuetext')`)), 'the address sets the rod');
  assert.strictEqual(await page.ask(`document.querySelector('canvas').width / document.querySelector('canvas').clientWidth`), 2, 'sharp');
  // The torque's box, its slider, its value typed.
  await click(page, 'input[name=torque-on]');
  await said(page, /^torque 0 N·m at t/);
  await click(page, 'input[name=torque-on]');
  await said(page, /^torque 1 N·m at t/);
  await set(page, 'input[name=torque]', 1000, 'input', 'change');
  await said(page, /^torque [2-9][\d.]* N·m at t/);
  await set(page, 'input[name=torque] + input', '0,5', 'change');
  await said(page, /^torque 0.5 N·m at t/);
  await set(page, 'select[name=stabilization]', 'none', 'change');
  await said(page, /^stabilization none at t/);
  await pressed(page, 'pause');
  await pressed(page, 'reset');
  await said(page, /^reset at t/);
  // The wheel stands in the left part of the scene: hold it somewhere, and it is pulled.
  const box = await canvas(page);
  let pulled = false;
  for (let y = 0.2; y < 0.7 && !pulled; y += 0.05) {
    const at = [box.left + 0.27 * box.width, box.top + y * box.height];
    await page.mouse('Moved', ...at);
    await page.mouse('Pressed', ...at);
    await pause(300);
    pulled = await page.ask(`document.querySelector('[data-chapter]').scene.lines.some((line) => line.startsWith('pulled'))`);
    await page.mouse('Moved', at[0] + 30, at[1] + 10, {buttons: 1});
    await page.mouse('Released', ...at);
  }
  await said(page, /^let go at t/);
  // On a phone: the controls are large enough for a finger, and nothing stands beside the page.
  await page.size(360, 740, 2, true);
  await pause(500);
  assert(await page.ask(`[...document.querySelectorAll('.panel button, .panel input[type=range], .panel select')].every((one) => one.getBoundingClientRect().height >= 32)`), 'large controls');
  assert(await page.ask('document.documentElement.scrollWidth <= innerWidth'), 'nothing beside the page');
  const small = await canvas(page), finger = {x: small.left + 0.27 * small.width, y: small.top + 0.25 * small.height};
  const touch = (type, points) => page.send('Input.dispatchTouchEvent', {type, touchPoints: points});
  await page.ask(`document.querySelector('[data-chapter]').scene.lines.length = 0`);
  await page.send('Emulation.setTouchEmulationEnabled', {enabled: true});
  for (let y = 0.15; y < 0.5 && !(await page.ask(`document.querySelector('[data-chapter]').scene.lines.some((line) => line.startsWith('pulled'))`)); y += 0.05) {
    const at = {x: finger.x, y: small.top + y * small.height};
    await touch('touchStart', [at]);
    await pause(300);
    await touch('touchMove', [{x: at.x + 20, y: at.y}]);
    await pause(100);
    await touch('touchEnd', []);
  }
  await said(page, /^let go at t/);
}

async function screenshots(page, url) {
  fs.mkdirSync(pictures, {recursive: true});
  for (const width of [360, 800, 1400])
    for (const scheme of ['light', 'dark']) {
      await page.size(width, width < 500 ? 1500 : 1000, 1);
      await page.media(scheme);
      await page.go(`${url}?`);
      await page.picture(path.join(pictures, `${chapter}_${width}_${scheme}_still.png`));
      await click(page, '.scene-start');
      await said(page, /^runs at t = 0 s/);
      await pause(3000);
      await page.ask(`document.querySelector('.scene').scrollIntoView({behavior: 'instant'})`);
      await pause(500);
      await page.picture(path.join(pictures, `${chapter}_${width}_${scheme}_live.png`));
    }
}

(async () => {
  const server = await serve(out), home = `http://127.0.0.1:${server.address().port}/`, url = `${home}chapters/${chapter}/index.html`;
  const page = await launch(program);
  try {
    await everyChapter(page, url);
    if (chapter === '07_slider_crank') await sliderCrank(page, url);
    if (pictures) await screenshots(page, url);
    assert.deepStrictEqual(page.log, [], 'nothing on the console');
    assert.deepStrictEqual(page.requests.filter((one) => !one.startsWith(home) && !/^(data|blob|about):/.test(one)), [], 'no request elsewhere');
  } finally {
    if (page.log.length) console.log(page.log.join('\n'));
    await page.close();
    server.close();
  }
  console.log(`${chapter}: ${page.requests.length} requests, all here`);
})().catch((error) => {
  console.error(error);
  process.exit(1);
});
