export function ComposerPage() { return <div class="empty" />; }
