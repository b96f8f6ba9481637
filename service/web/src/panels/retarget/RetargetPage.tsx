export function RetargetPage() { return <div class="empty" />; }
