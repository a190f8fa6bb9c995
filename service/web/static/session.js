// A session's pages: what is live, what is kept until the server has it.
import { follow } from "./live.js";
import { keepTyped } from "./outbox.js";
import { followForce } from "./pull.js";

const { session } = document.body.dataset;
keepTyped(session);
followForce();
if (session) follow(session);
