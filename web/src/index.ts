// What the page loads: the connection's worker, and then the page itself.

import "./styles/index.css";
import { missing } from "./fatal";
import "./socket";

import("./main").catch((error: unknown) => missing(String(error)));
