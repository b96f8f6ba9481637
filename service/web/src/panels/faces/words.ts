import { wordsOf } from "../../words/table";

export const f = wordsOf(
  {
    "label.title": "Expression space", "help.intro": "Facial animations, made on a map of expressions: the path between the expressions that you pick is the animation.",
    "help.missing": "No clip in this library has markers yet.", "help.needs": "Requires clips of facial markers (C3D, TRC) with at least 4 markers in common.", "button.build": "Build map", "label.building": "Building: {stage}",
    "label.recent": "Maps, newest first", "help.none": "No maps yet.", "label.options": "Options", "label.level": "Level", "label.candidates": "1 expression|{n} expressions", "label.levelOf": "{n} expressions to choose from",
    "label.links": "Links", "label.linksHidden": "{n} links: too many to draw", "label.takes": "Clips", "label.allTakes": "All clips", "label.mapLabel": "Map of {n} frames", "button.fit": "Zoom to map",
    "label.face": "Expression", "label.markersSkin": "Markers", "label.surfaceSkin": "Surface", "label.meshSkin": "Custom mesh", "button.openMesh": "Open mesh (OBJ, GLB)", "error.badMesh": "No mesh found in this file. Open an OBJ or GLB file.",
    "label.shown": "{take}, frame {frame}", "label.path": "Path", "help.pathHelp": "Click an expression on the map, then a linked one.", "label.keyOf": "Expression {n}", "button.removeKey": "Remove expression {n}",
    "label.linkedTo": "{n} mm", "help.notLinked": "Not linked at this level.", "help.route": "Via 1 expression, {mm} mm.|Via {n} expressions, {mm} mm.", "button.takeRoute": "Use this path", "help.noRoute": "Not reachable at this level. Finer levels have more links.",
    "button.walk": "Create animation", "label.walking": "Creating animation", "label.total": "{mm} mm", "label.version": "Version {n}", "label.versions": "Versions", "button.newPath": "New path", "label.speed": "Speed", "label.loop": "There and back", "label.smooth": "Smooth",
    "label.refine": "Refine", "label.offered": "1 expression suggested nearby|{n} expressions suggested nearby", "button.auto": "Refine automatically", "label.detour": "{mm} mm longer", "help.noOffers": "No suggestions at this level.", "label.bound": "Limit",
    "label.thisMap": "This map", "label.frames": "Frames", "label.framesOf": "{frames} from {takes} clips", "label.threshold": "Threshold", "label.thresholdOf": "{mm} mm", "label.unbroken": "fully connected", "label.bridges": "1 bridge|{n} bridges", "label.fits": "Fit", "label.fitOf": "r {r}, stress {stress}",
    "label.weak": "2-D map is approximate", "label.tauCurve": "How the threshold was chosen", "label.correlation": "correlation", "label.stress": "stress", "label.stretch": "stretch", "help.stretchHelp": "Stretch: length of paths along links relative to straight lines.", "button.save": "Save as clip", "label.saved": "{name} saved", "button.export": "Export", "label.picture": "Picture", "label.clipName": "Clip name",
    "button.add": "Add to path", "label.markersUsed": "Markers", "label.leftOut": "{n} left out", "label.pathOf": "between expressions",
  },
  {
    "label.title": "표정 공간", "help.intro": "표정 지도에서 표정을 고르면 그 사이의 경로가 얼굴 애니메이션이 됩니다.",
    "help.missing": "이 라이브러리에는 마커가 있는 클립이 아직 없습니다.", "help.needs": "공통 마커가 4개 이상인 얼굴 마커 클립(C3D, TRC)이 필요합니다.", "button.build": "지도 만들기", "label.building": "만드는 중: {stage}",
    "label.recent": "지도, 최신순", "help.none": "아직 지도가 없습니다.", "label.options": "옵션", "label.level": "수준", "label.candidates": "표정 {n}개", "label.levelOf": "고를 수 있는 표정 {n}개",
    "label.links": "연결", "label.linksHidden": "연결 {n}개는 너무 많아 그리지 않습니다", "label.takes": "클립", "label.allTakes": "모든 클립", "label.mapLabel": "{n}프레임의 지도", "button.fit": "지도에 맞추기",
    "label.face": "표정", "label.markersSkin": "마커", "label.surfaceSkin": "표면", "label.meshSkin": "내 메시", "button.openMesh": "메시 열기 (OBJ, GLB)", "error.badMesh": "이 파일에는 메시가 없습니다. OBJ나 GLB 파일을 여세요.",
    "label.shown": "{take}, {frame}번 프레임", "label.path": "경로", "help.pathHelp": "지도에서 표정을 누르고, 연결된 표정을 누르세요.", "label.keyOf": "표정 {n}", "button.removeKey": "표정 {n} 제거",
    "label.linkedTo": "{n} mm", "help.notLinked": "이 수준에서는 연결되어 있지 않습니다.", "help.route": "표정 {n}개를 거쳐 {mm} mm.", "button.takeRoute": "이 경로 사용", "help.noRoute": "이 수준에서는 갈 수 없습니다. 더 세밀한 수준에는 연결이 더 많습니다.",
    "button.walk": "애니메이션 만들기", "label.walking": "애니메이션을 만드는 중", "label.total": "{mm} mm", "label.version": "버전 {n}", "label.versions": "버전", "button.newPath": "새 경로", "label.speed": "속력", "label.loop": "갔다가 돌아오기", "label.smooth": "다듬기",
    "label.refine": "세분하기", "label.offered": "가까운 추천 표정 {n}개", "button.auto": "자동 세분", "label.detour": "{mm} mm 더", "help.noOffers": "이 수준에는 추천이 없습니다.", "label.bound": "한도",
    "label.thisMap": "이 지도", "label.frames": "프레임", "label.framesOf": "클립 {takes}개의 {frames}프레임", "label.threshold": "임계값", "label.thresholdOf": "{mm} mm", "label.unbroken": "모두 연결됨", "label.bridges": "브리지 {n}개", "label.fits": "적합도", "label.fitOf": "r {r}, 스트레스 {stress}",
    "label.weak": "2차원 지도는 근사입니다", "label.tauCurve": "임계값을 고른 방법", "label.correlation": "상관", "label.stress": "스트레스", "label.stretch": "늘임", "help.stretchHelp": "늘임: 직선에 대한, 연결을 따라가는 경로의 길이.", "button.save": "클립으로 저장", "label.saved": "{name}: 저장했습니다", "button.export": "내보내기", "label.picture": "그림", "label.clipName": "클립 이름",
    "button.add": "경로에 추가", "label.markersUsed": "마커", "label.leftOut": "{n}개 제외", "label.pathOf": "표정 사이",
  },
);
