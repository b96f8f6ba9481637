import { render } from "preact";
import "./styles/tokens.css";
import "./styles/base.css";
import "./styles/shell.css";
import { App } from "./shell/App";
import { effect } from "@preact/signals";
import { forget } from "./motion/loading/source";
import { PAGES } from "./pages";
import { followEvents, news } from "./state/session/events";
import { followHistory } from "./state/session/route";
import { followKeys } from "./state/session/keys";
import { followKept } from "./state/session/jobs";
import { followSettings } from "./state/session/settings";

followSettings();
followHistory(PAGES);
followKeys();
followEvents();
followKept();
// Motion that somebody changed is asked anew where it is played next.
effect(() => {
  if (news.value) forget(news.value.document);
});
render(<App />, document.getElementById("app")!);
