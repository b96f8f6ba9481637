import { wordsOf } from "../../words/table";

export const f = wordsOf(
  {
    title: "Expression space", intro: "A map of facial expressions. Pick expressions on the map; the path becomes an animation.",
    needs: "Requires clips of facial markers (C3D, TRC) with at least 4 markers in common.", demo: "Build the demo map", build: "Build map", building: "Building: {stage}",
    recent: "Maps, newest first", none: "No maps yet.", options: "Options", level: "Level", candidates: "1 expression|{n} expressions", levelOf: "{n} expressions to choose from",
    links: "Links", linksHidden: "{n} links: too many to draw", takes: "Clips", allTakes: "All clips", mapLabel: "Map of {n} frames", fit: "Zoom to map",
    face: "Expression", markersSkin: "Markers", surfaceSkin: "Surface", meshSkin: "Custom mesh", openMesh: "Open mesh (OBJ, GLB)", badMesh: "No mesh found in this file. Open an OBJ or GLB file.",
    shown: "{take}, frame {frame}", path: "Path", pathHelp: "Click an expression on the map, then a linked one.", keyOf: "Expression {n}", removeKey: "Remove expression {n}",
    linkedTo: "{n} mm", notLinked: "Not linked at this level.", route: "Via 1 expression, {mm} mm.|Via {n} expressions, {mm} mm.", takeRoute: "Use this path", noRoute: "Not reachable at this level. Finer levels have more links.",
    walk: "Create animation", walking: "Creating animation", total: "{mm} mm", version: "Version {n}", versions: "Versions", newPath: "New path", natural: "Natural speed", speed: "Speed", loop: "There and back", smooth: "Smooth",
    refine: "Refine", offered: "1 expression suggested nearby|{n} expressions suggested nearby", auto: "Refine automatically", detour: "{mm} mm longer", near: "{mm} mm away", noOffers: "No suggestions at this level.", bound: "Limit",
    thisMap: "This map", frames: "Frames", framesOf: "{frames} from {takes} clips", threshold: "Threshold", thresholdOf: "{mm} mm", unbroken: "fully connected", bridges: "1 bridge|{n} bridges", fits: "Fit", fitOf: "r {r}, stress {stress}",
    weak: "2-D map is approximate", tauCurve: "How the threshold was chosen", correlation: "correlation", stress: "stress", stretch: "stretch", stretchHelp: "Stretch: length of paths along links relative to straight lines.", save: "Save as clip", saved: "{name} saved", export: "Export", picture: "Picture", clipName: "Clip name",
    add: "Add to path", markersUsed: "Markers", leftOut: "{n} left out", pathOf: "between expressions",
  },
  {
    title: "표정 공간", intro: "얼굴 표정의 지도입니다. 지도에서 표정을 고르면 그 경로가 애니메이션이 됩니다.",
    needs: "공통 마커가 4개 이상인 얼굴 마커 클립(C3D, TRC)이 필요합니다.", demo: "데모 지도 만들기", build: "지도 만들기", building: "만드는 중: {stage}",
    recent: "지도, 최신순", none: "아직 지도가 없습니다.", options: "옵션", level: "수준", candidates: "표정 {n}개", levelOf: "고를 수 있는 표정 {n}개",
    links: "연결", linksHidden: "연결 {n}개는 너무 많아 그리지 않습니다", takes: "클립", allTakes: "모든 클립", mapLabel: "{n}프레임의 지도", fit: "지도에 맞추기",
    face: "표정", markersSkin: "마커", surfaceSkin: "표면", meshSkin: "내 메시", openMesh: "메시 열기 (OBJ, GLB)", badMesh: "이 파일에는 메시가 없습니다. OBJ나 GLB 파일을 여세요.",
    shown: "{take}, {frame}번 프레임", path: "경로", pathHelp: "지도에서 표정을 누르고, 연결된 표정을 누르세요.", keyOf: "표정 {n}", removeKey: "표정 {n} 제거",
    linkedTo: "{n} mm", notLinked: "이 수준에서는 연결되어 있지 않습니다.", route: "표정 {n}개를 거쳐 {mm} mm.", takeRoute: "이 경로 사용", noRoute: "이 수준에서는 갈 수 없습니다. 더 세밀한 수준에는 연결이 더 많습니다.",
    walk: "애니메이션 만들기", walking: "애니메이션을 만드는 중", total: "{mm} mm", version: "버전 {n}", versions: "버전", newPath: "새 경로", natural: "자연스러운 속력", speed: "속력", loop: "갔다가 돌아오기", smooth: "다듬기",
    refine: "세분하기", offered: "가까운 추천 표정 {n}개", auto: "자동 세분", detour: "{mm} mm 더", near: "{mm} mm 옆", noOffers: "이 수준에는 추천이 없습니다.", bound: "한도",
    thisMap: "이 지도", frames: "프레임", framesOf: "클립 {takes}개의 {frames}프레임", threshold: "임계값", thresholdOf: "{mm} mm", unbroken: "모두 연결됨", bridges: "브리지 {n}개", fits: "적합도", fitOf: "r {r}, 스트레스 {stress}",
    weak: "2차원 지도는 근사입니다", tauCurve: "임계값을 고른 방법", correlation: "상관", stress: "스트레스", stretch: "늘임", stretchHelp: "늘임: 직선에 대한, 연결을 따라가는 경로의 길이.", save: "클립으로 저장", saved: "{name}: 저장했습니다", export: "내보내기", picture: "그림", clipName: "클립 이름",
    add: "경로에 추가", markersUsed: "마커", leftOut: "{n}개 제외", pathOf: "표정 사이",
  },
);
