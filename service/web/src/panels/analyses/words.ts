import { wordsOf } from "../../words/table";

export const a = wordsOf(
  {
    "help.intro": "Run analyses of clips, and use their results.",
    "help.window": "Opens in {name}.", "label.clipsWord": "Clips", "label.parameters": "Options", "label.nameOfResult": "Result name",
    "help.needs": "Takes {least} to {most} clips.", "help.tooFew": "Choose at least {n} clip.|Choose at least {n} clips.", "button.start": "Run {name}", 
    "label.recent": "Results, newest first", "help.noResults": "No results yet.", "label.parts": "Parts", "label.operations": "Actions", "button.apply": "Apply",
    "label.madeFrom": "Made from {n} clip|Made from {n} clips", "button.deleteResult": "Delete result", "label.resultDeleted": "Result deleted", "label.storedAs": "Saved as a clip", "label.playIt": "Generated motion",
    "label.moreRows": "and {n} more row|and {n} more rows", "help.noArray": "This part has no values to plot.", "label.keptAs": "Saved as a result", "button.saveClip": "Save as clip", "label.clipName": "Clip name",
    "label.allValues": "Values", "button.download": "Download as {format}", "label.by": "{analysis}, {when}",
  },
  {
    "help.intro": "클립을 분석하고 그 결과를 사용합니다.",
    "help.window": "{name}에서 열립니다.", "label.clipsWord": "클립", "label.parameters": "옵션", "label.nameOfResult": "결과 이름",
    "help.needs": "클립 {least}~{most}개를 사용합니다.", "help.tooFew": "클립을 {n}개 이상 고르세요.", "button.start": "{name} 실행", 
    "label.recent": "결과, 최신순", "help.noResults": "아직 결과가 없습니다.", "label.parts": "구성 부분", "label.operations": "실행할 수 있는 작업", "button.apply": "실행",
    "label.madeFrom": "클립 {n}개로 만들었습니다", "button.deleteResult": "결과 삭제", "label.resultDeleted": "결과를 삭제했습니다", "label.storedAs": "클립으로 저장했습니다", "label.playIt": "만든 동작",
    "label.moreRows": "외 {n}행", "help.noArray": "이 부분에는 그릴 값이 없습니다.", "label.keptAs": "결과로 저장했습니다", "button.saveClip": "클립으로 저장", "label.clipName": "클립 이름",
    "label.allValues": "값", "button.download": "{format}(으)로 다운로드", "label.by": "{analysis}, {when}",
  },
  {
    "help.intro": "クリップの分析を実行し、その結果を使います。",
    "help.window": "{name} で開きます。", "label.clipsWord": "クリップ", "label.parameters": "オプション", "label.nameOfResult": "結果の名前",
    "help.needs": "クリップを {least} から {most} 件使います。", "help.tooFew": "{n} クリップ以上を選んでください。", "button.start": "{name} を実行", 
    "label.recent": "結果(新しい順)", "help.noResults": "結果はまだありません。", "label.parts": "構成要素", "label.operations": "操作", "button.apply": "適用",
    "label.madeFrom": "{n} クリップから作成", "button.deleteResult": "結果を削除", "label.resultDeleted": "結果を削除しました", "label.storedAs": "クリップとして保存しました", "label.playIt": "生成されたモーション",
    "label.moreRows": "ほか {n} 行", "help.noArray": "この部分には描画できる値がありません。", "label.keptAs": "結果として保存しました", "button.saveClip": "クリップとして保存", "label.clipName": "クリップ名",
    "label.allValues": "値", "button.download": "{format} としてダウンロード", "label.by": "{analysis}、{when}",
  },
);
