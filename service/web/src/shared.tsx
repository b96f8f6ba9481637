/** The page that a link to some documents opens: for people without an account, so without all the rest. */
import { render } from "preact";
import "./styles/tokens.css";
import "./styles/base.css";
import "./styles/shell.css";
import "./styles/shared.css";
import { SharedPage } from "./panels/shared/SharedPage";
import { followSettings } from "./state/session/settings";

followSettings();
render(<SharedPage secret={decodeURIComponent(location.hash.slice(1))} />, document.getElementById("app")!);
