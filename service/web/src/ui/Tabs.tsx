/** Tabs after the ARIA pattern: one stop, arrows inside. */
export function Tabs({ label, tabs, open, onOpen }: { label: string; tabs: { id: string; text: string }[]; open: string; onOpen: (id: string) => void }) {
  return (
    <div class="tabs" role="tablist" aria-label={label}
      onKeyDown={(event) => {
        const at = tabs.findIndex((tab) => tab.id === open);
        const to = { ArrowLeft: at - 1, ArrowRight: at + 1, Home: 0, End: tabs.length - 1 }[event.key];
        if (to === undefined) return;
        const next = tabs[(to + tabs.length) % tabs.length];
        onOpen(next.id);
        event.currentTarget.querySelector<HTMLElement>(`#tab-${next.id}`)?.focus();
        event.preventDefault();
        event.stopPropagation();
      }}>
      {tabs.map((tab) => (
        <button key={tab.id} id={`tab-${tab.id}`} type="button" role="tab" aria-selected={tab.id === open} aria-controls={tab.id === open ? `panel-${tab.id}` : undefined} tabIndex={tab.id === open ? 0 : -1} onClick={() => onOpen(tab.id)}>{tab.text}</button>
      ))}
    </div>
  );
}
