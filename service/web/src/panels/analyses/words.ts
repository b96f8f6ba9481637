import { wordsOf } from "../../words/table";

export const a = wordsOf(
  {
    intro: "What the repository can find in clips, and make of them. Choose one; its form comes of what it takes.",
    window: "It has a window of its own: {name}.", clipsWord: "Clips", parameters: "Options", nameOfResult: "Name of the result",
    needs: "It takes {least} to {most} clips.", tooFew: "Choose at least {n} clip.|Choose at least {n} clips.", start: "Run {name}", running: "{stage}",
    recent: "Results, the newest first", noResults: "No results yet.", parts: "Parts", operations: "What can be done with it", apply: "Do it", doneWith: "Done.",
    madeFrom: "Made from {n} clip|Made from {n} clips", deleteResult: "Delete the result", resultDeleted: "Result deleted", storedAs: "Stored as a document", playIt: "What it made",
    moreRows: "and {n} more row|and {n} more rows", noArray: "This part names no values to draw.", keptAs: "Kept as a result", saveClip: "Store the clip as a document", clipName: "Name of the clip",
    allValues: "Values", download: "Save the picture as {format}", noPictures: "No picture can be drawn of it.", by: "{analysis}, {when}",
  },
  {
    intro: "저장소가 클립에서 찾고 만들 수 있는 것입니다. 하나를 고르면 필요한 양식이 나옵니다.",
    window: "전용 창이 있습니다: {name}.", clipsWord: "클립", parameters: "옵션", nameOfResult: "결과 이름",
    needs: "클립 {least}~{most}개를 사용합니다.", tooFew: "클립을 {n}개 이상 고르세요.", start: "{name} 실행", running: "{stage}",
    recent: "결과, 최신순", noResults: "아직 결과가 없습니다.", parts: "구성 부분", operations: "할 수 있는 일", apply: "실행", doneWith: "완료했습니다.",
    madeFrom: "클립 {n}개로 만들었습니다", deleteResult: "결과 삭제", resultDeleted: "결과를 삭제했습니다", storedAs: "문서로 저장했습니다", playIt: "만든 동작",
    moreRows: "외 {n}행", noArray: "이 부분에는 그릴 값이 없습니다.", keptAs: "결과로 보관했습니다", saveClip: "클립을 문서로 저장", clipName: "클립 이름",
    allValues: "값", download: "그림을 {format}으로 저장", noPictures: "그릴 수 있는 그림이 없습니다.", by: "{analysis}, {when}",
  },
);
