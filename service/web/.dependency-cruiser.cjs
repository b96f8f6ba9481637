/** Which parts of the studio may import which; `python -m tests.web.keeper layers`, as a part of `make check`. */
const not = (name, from, to) => ({ name, severity: "error", from, to });

module.exports = {
  forbidden: [
    not("no-circle", {}, { circular: true }),
    not("state-knows-no-ui", { path: "^src/((api|motion|state)/|lists)" }, { path: "^src/(ui|scene|shell|panels)/" }),
    not("ui-knows-no-panels", { path: "^src/(ui|scene)/" }, { path: "^src/(shell|panels)/" }),
    not("panels-know-no-shell", { path: "^src/panels/" }, { path: "^src/shell/" }),
    not("panels-apart", { path: "^src/panels/([^/]+)/" }, { path: "^src/panels/", pathNot: "^src/panels/$1/" }),
    not("only-scene-draws", { path: "^src/", pathNot: "^src/scene/" }, { path: "node_modules/three/" }),
  ],
  options: {
    doNotFollow: { path: "node_modules" },
    exclude: { path: "types\\.gen\\.ts$" },
    tsPreCompilationDeps: true,
    tsConfig: { fileName: "tsconfig.json" },
  },
};
