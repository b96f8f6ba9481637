/** Why a change is made, in words for those who review it or read the history. */
import { message } from "../../../state/clip/review";
import { r } from "../words";

export function MessageField() {
  return (
    <input
      class="field change-message"
      maxLength={1024}
      aria-label={r("label.message")}
      placeholder={r("label.message")}
      value={message.value}
      onInput={(event) => (message.value = event.currentTarget.value)}
    />
  );
}
