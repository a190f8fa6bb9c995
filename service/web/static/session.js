// A session's pages: what is live, and whether another tablet has gone on.
import { follow } from "./live.js";

const { session } = document.body.dataset;
if (session) follow(session);
