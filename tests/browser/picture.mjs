// Takes the README's picture of the whole page: starts the live server with a scene, opens its page in Chromium, shows it
// while somebody pulls.
//
//     node tests/browser/picture.mjs [PROGRAM] [SCENE] [PNG] [FRAGMENT]
//     node tests/browser/picture.mjs build/release/server/tetfront assets/scenes/bunny.json assets/pictures/browser.png
//
// FRAGMENT is what follows # in the page's address (web/src/share.ts): colour=stress&wire=1. Needs web/dist (npm run build).

import { spawn } from "node:child_process";
import { once } from "node:events";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
const { chromium } = createRequire(join(root, "web/package.json"))("playwright-core");
const [program, scene, file, fragment] = [
  process.argv[2] ?? join(root, "build/release/server/tetfront"),
  process.argv[3] ?? join(root, "assets/scenes/bunny.json"),
  process.argv[4] ?? join(root, "assets/pictures/browser.png"),
  process.argv[5] ?? "",
];

const server = spawn(program, ["serve", scene, "--port", "0", "--web", join(root, "web/dist")], {
  stdio: ["ignore", "pipe", "inherit"],
});
const [url] = await once(createInterface(server.stdout), "line");
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-background-networking"],
});
try {
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 }, colorScheme: "light" });
  page.setDefaultTimeout(180_000); // of the model's building, too
  await page.goto(`${url.trim()}${fragment ? `#${fragment}` : ""}`);
  await page.waitForFunction(() => (window.tetfront?.frame()?.time ?? 0) > 3);
  // Somebody pulls: from the first place under the middle of the picture where there is something to grab.
  const over = () => page.evaluate(() => document.getElementById("view").classList.contains("over-object"));
  for (const [x, y] of [
    [520, 250],
    [600, 330],
    [640, 300],
    [560, 380],
    [640, 400],
    [680, 350],
  ]) {
    await page.mouse.move(x, y);
    await page.waitForTimeout(600);
    if (!(await over())) continue;
    await page.mouse.down();
    await page.mouse.move(x - 60, y - 50, { steps: 5 });
    await page.waitForFunction(() => window.tetfront.frame().pulls.length > 0);
    await page.waitForTimeout(2500);
    break;
  }
  await page.screenshot({ path: file, timeout: 180_000 });
  console.log(file);
} finally {
  await browser.close();
  server.kill();
}
