// A session's pages: what is live, what is kept until the server has it.
import { follow } from "./live.js";
import { keepTyped } from "./outbox.js";

const { session } = document.body.dataset;
keepTyped(session);
if (session) follow(session);
