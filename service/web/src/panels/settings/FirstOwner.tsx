/** The first account, an owner's: it comes before invitations and tokens, which close the repository to others. */
import { useState } from "preact/hooks";
import { ask } from "../../api/client";
import { Trouble } from "../../ui/Trouble";
import { w } from "../../words";
import { s } from "./words";

export function FirstOwner() {
  const [given, setGiven] = useState({ name: "", password: "" });
  const [failed, setFailed] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const make = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    setFailed(null);
    try {
      await ask("post", "/accounts", { body: given });
      await ask("post", "/session", { body: given });
      location.reload();
    } catch (error) {
      setFailed(error);
      setBusy(false);
    }
  };
  return (
    <section aria-label={s("button.ownerFirst")}>
      <h3>{s("button.ownerFirst")}</h3>
      <p class="dim">{s("help.ownerFirstHelp")}</p>
      <Trouble error={failed} />
      <form class="row wrap" onSubmit={(event) => void make(event)}>
        <label>
          {w("label.name")}{" "}
          <input
            class="field"
            autocomplete="username"
            maxLength={64}
            required
            value={given.name}
            onInput={(event) => setGiven({ ...given, name: event.currentTarget.value })}
          />
        </label>
        <label>
          {s("label.newPassword")}{" "}
          <input
            class="field"
            type="password"
            autocomplete="new-password"
            minLength={10}
            maxLength={256}
            required
            value={given.password}
            onInput={(event) => setGiven({ ...given, password: event.currentTarget.value })}
          />
        </label>
        <button class="button primary" disabled={busy}>
          {s("button.createAccount")}
        </button>
      </form>
    </section>
  );
}
