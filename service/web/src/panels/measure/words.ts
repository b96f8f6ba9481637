import { wordsOf } from "../../words/table";

export const m = wordsOf(
  {
    "help.intro": "Measure any quantity in many clips: mean curves, and a table with outliers first.",
    "help.first": "Choose clips, then add a measurement.", "help.add": "Add a measurement to see curves and a table.",
    "label.setup": "Setup", "label.clips": "Clips", "label.measurements": "Measurements",
    "label.ranges": "Frame ranges", "label.whole": "Whole clips", "label.strides": "Strides of gait", "label.ofQuery": "Results of a query", "label.labels": "Labels",
    "label.query": "XPath query", "label.by": "Group by", "label.side": "Side", "label.sideAnd": "Side and {key}", "label.clip": "clip", "label.project": "project", "label.label": "label", "label.person": "person",
    "button.add": "Add", "button.addBoth": "Add both sides", "button.addGait": "Add gait angles", "button.addHands": "Add hand speeds", "button.addFeet": "Add foot heights", "button.remove": "Remove {name}",
    "label.result": "Curves and table", "label.curves": "Curves", "label.percent": "Percent of the range", "label.count": "n = {n}", "label.outliers": "{n} outlier|{n} outliers",
    "help.curves": "Mean with one standard deviation. Thin lines are single frame ranges; click one to play it.",
    "label.table": "Frame ranges", "label.tableOf": "Table of frame ranges", "label.totals": "{n} row of {clips} clips|{n} rows of {clips} clips", "label.moreGroups": "{n} more group|{n} more groups", "label.moreRows": "{n} more row in the downloads|{n} more rows in the downloads",
    "label.name": "Clip", "label.frames": "Frames", "label.quantity": "Measurement", "label.minimum": "Minimum", "label.maximum": "Maximum", "label.mean": "Mean", "label.sd": "SD", "label.range": "Range", "label.atMax": "Time of maximum", "label.score": "Score",
    "help.score": "Modified z-score: distance from the median of the group in robust standard deviations. Over 3.5 is an outlier.", "label.outlier": "Outlier",
    "label.notes": "{n} note|{n} notes", "button.download": "Download {format}", "button.close": "Close player", "label.curveOf": "{quantity}, mean of {n}|{quantity}, mean of {n}",
    "label.hiddenCurves": "first {n} drawn", "help.none": "No frame range has a value. The notes give the reasons.", "button.allAnalyses": "Show analyses and results",
  },
  {
    "help.intro": "여러 클립에서 원하는 값을 측정합니다. 평균 곡선과, 이상치를 맨 위에 둔 표를 보여 줍니다.",
    "help.first": "클립을 고른 다음 측정 항목을 추가하세요.", "help.add": "측정 항목을 추가하면 곡선과 표가 나타납니다.",
    "label.setup": "측정 설정", "label.clips": "클립", "label.measurements": "측정 항목",
    "label.ranges": "프레임 구간", "label.whole": "클립 전체", "label.strides": "보행 활보", "label.ofQuery": "쿼리 결과", "label.labels": "라벨",
    "label.query": "XPath 쿼리", "label.by": "그룹 기준", "label.side": "좌우", "label.sideAnd": "좌우와 {key}", "label.clip": "클립", "label.project": "프로젝트", "label.label": "라벨", "label.person": "사람",
    "button.add": "추가", "button.addBoth": "양쪽 추가", "button.addGait": "보행 각도 추가", "button.addHands": "손 속도 추가", "button.addFeet": "발 높이 추가", "button.remove": "{name} 제거",
    "label.result": "곡선과 표", "label.curves": "곡선", "label.percent": "구간 (%)", "label.count": "n = {n}", "label.outliers": "이상치 {n}개",
    "help.curves": "평균과 표준편차입니다. 가는 선은 프레임 구간 하나하나이며, 클릭하면 재생합니다.",
    "label.table": "프레임 구간", "label.tableOf": "프레임 구간 표", "label.totals": "클립 {clips}개, {n}행", "label.moreGroups": "나머지 그룹 {n}개", "label.moreRows": "나머지 {n}행은 다운로드에 있음",
    "label.name": "클립", "label.frames": "프레임", "label.quantity": "측정 항목", "label.minimum": "최소", "label.maximum": "최대", "label.mean": "평균", "label.sd": "표준편차", "label.range": "범위", "label.atMax": "최대 시점", "label.score": "점수",
    "help.score": "수정 z 점수: 그룹 중앙값에서 떨어진 거리를 강건한 표준편차로 나눈 값입니다. 3.5를 넘으면 이상치입니다.", "label.outlier": "이상치",
    "label.notes": "참고 {n}개", "button.download": "{format} 다운로드", "button.close": "플레이어 닫기", "label.curveOf": "{quantity}, 평균 (n = {n})",
    "label.hiddenCurves": "처음 {n}개만 표시", "help.none": "값이 있는 프레임 구간이 없습니다. 이유는 참고에 있습니다.", "button.allAnalyses": "분석과 결과 보기",
  },
);
