import { wordsOf } from "../../words/table";

export const a = wordsOf(
  {
    intro: "Run analyses of clips, and use their results.",
    window: "Opens in {name}.", clipsWord: "Clips", parameters: "Options", nameOfResult: "Result name",
    needs: "Takes {least} to {most} clips.", tooFew: "Choose at least {n} clip.|Choose at least {n} clips.", start: "Run {name}", running: "{stage}",
    recent: "Results, newest first", noResults: "No results yet.", parts: "Parts", operations: "Actions", apply: "Apply",
    madeFrom: "Made from {n} clip|Made from {n} clips", deleteResult: "Delete result", resultDeleted: "Result deleted", storedAs: "Saved as a clip", playIt: "Generated motion",
    moreRows: "and {n} more row|and {n} more rows", noArray: "This part has no values to plot.", keptAs: "Saved as a result", saveClip: "Save as clip", clipName: "Clip name",
    allValues: "Values", download: "Download as {format}", by: "{analysis}, {when}",
  },
  {
    intro: "클립을 분석하고 그 결과를 사용합니다.",
    window: "{name}에서 열립니다.", clipsWord: "클립", parameters: "옵션", nameOfResult: "결과 이름",
    needs: "클립 {least}~{most}개를 사용합니다.", tooFew: "클립을 {n}개 이상 고르세요.", start: "{name} 실행", running: "{stage}",
    recent: "결과, 최신순", noResults: "아직 결과가 없습니다.", parts: "구성 부분", operations: "실행할 수 있는 작업", apply: "실행",
    madeFrom: "클립 {n}개로 만들었습니다", deleteResult: "결과 삭제", resultDeleted: "결과를 삭제했습니다", storedAs: "클립으로 저장했습니다", playIt: "만든 동작",
    moreRows: "외 {n}행", noArray: "이 부분에는 그릴 값이 없습니다.", keptAs: "결과로 저장했습니다", saveClip: "클립으로 저장", clipName: "클립 이름",
    allValues: "값", download: "{format}(으)로 다운로드", by: "{analysis}, {when}",
  },
);
