import { wordsOf } from "../../words/table";

export const f = wordsOf(
  {
    title: "Expression space", intro: "A map of all faces of some takes. One walks on it from face to face, and the walk is an animation.",
    needs: "Takes of labelled points (C3D, TRC) with at least 4 markers in common.", demo: "Make the demo map", build: "Build the map", building: "Building: {stage}",
    recent: "Maps, the newest first", none: "No map yet.", options: "Options", level: "Level", candidates: "1 face|{n} faces", levelOf: "{n} faces to choose from",
    links: "Links", linksHidden: "{n} links are too many to draw", takes: "Takes", allTakes: "All takes", mapLabel: "Map of {n} frames", fit: "Fit the map",
    face: "Face", markersSkin: "Markers", surfaceSkin: "Surface", meshSkin: "Own mesh", openMesh: "Open a mesh (OBJ or GLB)", badMesh: "This file holds no mesh: OBJ and GLB are read.",
    shown: "{take}, frame {frame}", path: "Path", pathHelp: "Click a face on the map, then one that is linked to it.", keyOf: "Face {n}", removeKey: "Take face {n} away",
    linkedTo: "{n} mm", notLinked: "Not linked at this level.", route: "By 1 face between, {mm} mm.|By {n} faces between, {mm} mm.", takeRoute: "Take this way", noRoute: "No way leads there at this level: a finer level has more links.",
    walk: "Make the animation", walking: "Making it", total: "{mm} mm", version: "Version {n}", versions: "Versions", newPath: "New path", natural: "Natural speed", speed: "Speed", loop: "There and back", smooth: "Smooth",
    refine: "Refine", offered: "1 face is offered near it|{n} faces are offered near it", auto: "Refine by itself", autoHelp: "at most {percent} % longer", detour: "{mm} mm more", near: "{mm} mm beside it", noOffers: "Nothing is offered at this level.", bound: "Bound",
    thisMap: "This map", frames: "Frames", framesOf: "{frames} of {takes} takes", threshold: "Threshold", thresholdOf: "{mm} mm", unbroken: "no broken ways", bridges: "1 bridge|{n} bridges", fits: "Fit", fitOf: "r {r}, stress {stress}",
    weak: "in two dimensions faces overlap", tauCurve: "How the threshold was chosen", correlation: "correlation", stress: "stress", stretch: "stretch", stretchHelp: "Stretch: how much longer the ways along links are than straight ones.", save: "Save as clip", saved: "{name}: saved", export: "Export", picture: "Picture", clipName: "Name of the clip",
    add: "Add to the path", crossLabel: "Where the animation is on the map", markersUsed: "Markers", leftOut: "{n} left out", pathOf: "from face to face",
  },
  {
    title: "표정 공간", intro: "여러 테이크의 모든 얼굴을 담은 지도입니다. 얼굴에서 얼굴로 걸으면 그 길이 애니메이션이 됩니다.",
    needs: "공통 마커가 4개 이상인 테이크(C3D, TRC)가 필요합니다.", demo: "데모 지도 만들기", build: "지도 만들기", building: "만드는 중: {stage}",
    recent: "지도, 최신순", none: "아직 지도가 없습니다.", options: "옵션", level: "수준", candidates: "얼굴 {n}개", levelOf: "고를 수 있는 얼굴 {n}개",
    links: "연결", linksHidden: "연결 {n}개는 너무 많아 그리지 않습니다", takes: "테이크", allTakes: "모든 테이크", mapLabel: "프레임 {n}개의 지도", fit: "지도에 맞추기",
    face: "얼굴", markersSkin: "마커", surfaceSkin: "표면", meshSkin: "내 메시", openMesh: "메시 열기 (OBJ, GLB)", badMesh: "이 파일에는 메시가 없습니다. OBJ와 GLB를 읽을 수 있습니다.",
    shown: "{take}, {frame}번 프레임", path: "경로", pathHelp: "지도에서 얼굴을 누르고, 그와 연결된 얼굴을 누르세요.", keyOf: "얼굴 {n}", removeKey: "얼굴 {n} 빼기",
    linkedTo: "{n} mm", notLinked: "이 수준에서는 연결되어 있지 않습니다.", route: "사이에 얼굴 {n}개, {mm} mm입니다.", takeRoute: "이 길로 가기", noRoute: "이 수준에서는 길이 없습니다. 더 세밀한 수준에는 연결이 더 많습니다.",
    walk: "애니메이션 만들기", walking: "만드는 중", total: "{mm} mm", version: "버전 {n}", versions: "버전", newPath: "새 경로", natural: "자연스러운 속력", speed: "속력", loop: "갔다가 돌아오기", smooth: "다듬기",
    refine: "세분하기", offered: "가까운 후보 얼굴 {n}개", auto: "자동 세분", autoHelp: "최대 {percent} % 더 길게", detour: "{mm} mm 더", near: "{mm} mm 옆", noOffers: "이 수준에는 후보가 없습니다.", bound: "한도",
    thisMap: "이 지도", frames: "프레임", framesOf: "테이크 {takes}개의 {frames}개", threshold: "문턱값", thresholdOf: "{mm} mm", unbroken: "끊긴 길 없음", bridges: "다리 {n}개", fits: "적합도", fitOf: "r {r}, 스트레스 {stress}",
    weak: "2차원에서는 얼굴이 겹칩니다", tauCurve: "문턱값을 고른 방법", correlation: "상관", stress: "스트레스", stretch: "늘임", stretchHelp: "늘임: 링크를 따라가는 길이 직선보다 얼마나 긴지.", save: "클립으로 저장", saved: "{name}: 저장했습니다", export: "내보내기", picture: "그림", clipName: "클립 이름",
    add: "경로에 넣기", crossLabel: "지도에서 애니메이션의 위치", markersUsed: "마커", leftOut: "{n}개 제외", pathOf: "얼굴에서 얼굴로",
  },
);
