/** A form on its way to the server, told how much of it went. */
import { address, ApiError, Offline, type Problem } from "../../api/client";

/** What the server answered. ApiError, Offline, AbortError. sent: 0 to 1. */
export function send<T>(path: string, form: FormData, sent: (share: number) => void, signal: AbortSignal): Promise<T> {
  return new Promise((resolve, reject) => {
    // fetch() tells nothing of what was sent; XMLHttpRequest does.
    const request = new XMLHttpRequest();
    request.open("POST", address(path));
    request.setRequestHeader("accept", "application/json");
    request.upload.onprogress = (event) => sent(event.total ? event.loaded / event.total : 0);
    request.upload.onload = () => sent(1);
    request.onabort = () => reject(new DOMException("", "AbortError"));
    request.onerror = () => reject(new Offline("The server does not answer."));
    request.onload = () => {
      let answer: unknown = {};
      try {
        answer = JSON.parse(request.responseText);
      } catch {
        /* No words at all. */
      }
      if (request.status >= 200 && request.status < 300) resolve(answer as T);
      else reject(new ApiError(request.status, answer as Problem));
    };
    signal.addEventListener("abort", () => request.abort());
    request.send(form);
  });
}
