// A headless Chromium, spoken to through its debugging pipe: messages in JSON, each ended by a zero.
'use strict';
const {spawn} = require('child_process');
const fs = require('fs');
const os = require('os');
const path = require('path');

/// Starts one and opens a page in it. What the page says, throws and requests is in `log` and `requests`.
async function launch(program) {
  const home = fs.mkdtempSync(path.join(os.tmpdir(), 'book_'));
  const browser = spawn(program, ['--headless=new', '--no-sandbox', '--disable-gpu-sandbox', '--remote-debugging-pipe',
    `--user-data-dir=${home}`, '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
    '--no-first-run', '--disable-background-networking', '--disable-component-update', 'about:blank'],
  {stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe']});
  const [, , , into, from] = browser.stdio;
  let count = 0, rest = '', session;
  const waiting = {}, log = [], requests = [];
  const heard = ({id, error, result, method, params}) => {
    if (id) return error ? waiting[id][1](new Error(error.message)) : waiting[id][0](result);
    if (method === 'Runtime.consoleAPICalled') log.push(params.args.map((part) => part.value).join(' '));
    if (method === 'Runtime.exceptionThrown') log.push(params.exceptionDetails.exception?.description || params.exceptionDetails.text);
    if (method === 'Log.entryAdded') log.push(params.entry.text);
    if (method === 'Network.requestWillBeSent') requests.push(params.request.url);
  };
  from.setEncoding('utf8').on('data', (text) => {
    const messages = (rest + text).split('\0');
    rest = messages.pop();
    messages.forEach((message) => heard(JSON.parse(message)));
  });
  const send = (method, params = {}) => new Promise((...both) => {
    waiting[++count] = both;
    into.write(`${JSON.stringify({id: count, method, params, sessionId: session})}\0`);
  });
  const {targetInfos} = await send('Target.getTargets');
  const {targetId} = targetInfos.find(({type}) => type === 'page');
  ({sessionId: session} = await send('Target.attachToTarget', {targetId, flatten: true}));
  for (const part of ['Page', 'Runtime', 'Log', 'Network']) await send(`${part}.enable`);

  const page = {log, requests, send};
  page.size = (width, height, scale = 1, mobile = false) =>
    send('Emulation.setDeviceMetricsOverride', {width, height, deviceScaleFactor: scale, mobile});
  page.media = (scheme) => send('Emulation.setEmulatedMedia', {features: [{name: 'prefers-color-scheme', value: scheme}]});
  /// The value of an expression in the page.
  page.ask = async (expression) => {
    const {result, exceptionDetails} = await send('Runtime.evaluate', {expression, awaitPromise: true, returnByValue: true});
    if (exceptionDetails) throw new Error(`${expression}: ${exceptionDetails.exception.description}`);
    return result.value;
  };
  /// Waits until the expression holds.
  page.until = async (expression, seconds = 60) => {
    const end = Date.now() + 1000 * seconds;
    while (!(await page.ask(expression))) {
      if (Date.now() > end) throw new Error(`not within ${seconds} s: ${expression}`);
      await new Promise((done) => setTimeout(done, 50));
    }
  };
  page.go = async (url) => {
    await send('Page.navigate', {url});
    await page.until(`location.href === ${JSON.stringify(url)} && document.readyState === 'complete'`);
  };
  page.key = async (key, code = key) => {
    const numbers = {Tab: 9, Escape: 27, ' ': 32, Enter: 13};
    const event = {key, code, windowsVirtualKeyCode: numbers[key], text: {' ': ' ', Enter: '\r'}[key]};
    await send('Input.dispatchKeyEvent', {type: 'keyDown', ...event});
    await send('Input.dispatchKeyEvent', {type: 'keyUp', ...event});
  };
  page.mouse = (type, x, y, more = {}) =>
    send('Input.dispatchMouseEvent', {type: `mouse${type}`, x, y, button: 'left', clickCount: 1, ...more});
  page.picture = async (file) =>
    fs.writeFileSync(file, Buffer.from((await send('Page.captureScreenshot')).data, 'base64'));
  page.close = async () => {
    session = undefined;
    const gone = new Promise((done) => browser.on('exit', done));
    send('Browser.close').catch(() => {});
    await gone;
    fs.rmSync(home, {recursive: true, force: true, maxRetries: 5});
  };
  return page;
}

module.exports = {launch};
