import { render } from "preact";
import "./styles/tokens.css";
import "./styles/base.css";
import "./styles/shell.css";
import { App } from "./shell/App";
import { followEvents } from "./state/events";
import { followHistory } from "./state/route";
import { followKeys } from "./state/keys";
import { followSettings } from "./state/settings";

followSettings();
followHistory();
followKeys();
followEvents();
render(<App />, document.getElementById("app")!);
