export function XPathPage() { return <div class="empty" />; }
