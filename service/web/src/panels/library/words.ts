import { wordsOf } from "../../words/table";

export const i = wordsOf(
  {
    "label.file": "File", "label.outcome": "Outcome", "label.message": "Message", "label.actions": "Actions", "label.findings": "Findings", "label.all": "All",
    "label.underway": "in progress", "label.refused": "import failed", "label.warned": "with warnings", "label.existing": "already here", "label.stored": "imported", "label.cancelled": "cancelled",
    "label.foldersBy": "Folders by", "label.noFolders": "no folders", "label.folders": "Folders", "button.closeFolders": "Show all clips without folders", "help.noFolders": "No clip under these filters has a value.", "help.mostFolders": "The first {n} folders are shown. Filter the clips to see others.",
    "label.filtersActive": "Filters, {n} active", "button.showClips": "Show {n} clip|Show {n} clips",
    "label.moreWarnings": "and {n} more warning|and {n} more warnings", "label.reportCopied": "Import report copied",
    "button.showReport": "Show report", "button.hideReport": "Hide report", "button.selectImported": "Select {n} imported clip|Select all {n} imported clips", "button.copyReport": "Copy CSV", "button.saveReport": "Download CSV", "button.cancelFile": "Cancel {name}",
  },
  {
    "label.file": "파일", "label.outcome": "결과", "label.message": "내용", "label.actions": "동작", "label.findings": "읽은 정보", "label.all": "전체",
    "label.underway": "진행 중", "label.refused": "가져오기 실패", "label.warned": "경고 있음", "label.existing": "이미 있음", "label.stored": "가져옴", "label.cancelled": "취소됨",
    "label.foldersBy": "폴더 기준", "label.noFolders": "폴더 없음", "label.folders": "폴더", "button.closeFolders": "폴더 없이 모든 클립 보기", "help.noFolders": "이 필터에 맞는 클립에는 값이 없습니다.", "help.mostFolders": "처음 {n}개 폴더만 보입니다. 나머지는 필터로 좁혀 보세요.",
    "label.filtersActive": "필터, {n}개 적용됨", "button.showClips": "클립 {n}개 보기",
    "label.moreWarnings": "외 경고 {n}개", "label.reportCopied": "가져오기 보고서를 복사했습니다",
    "button.showReport": "보고서 보기", "button.hideReport": "보고서 접기", "button.selectImported": "가져온 클립 {n}개 모두 선택", "button.copyReport": "CSV 복사", "button.saveReport": "CSV 다운로드", "button.cancelFile": "{name} 취소",
  },
  {
    "label.file": "ファイル", "label.outcome": "結果", "label.message": "メッセージ", "label.actions": "操作", "label.findings": "検出内容", "label.all": "すべて",
    "label.underway": "処理中", "label.refused": "インポート失敗", "label.warned": "警告あり", "label.existing": "既存", "label.stored": "インポート済み", "label.cancelled": "キャンセル済み",
    "label.foldersBy": "分類", "label.noFolders": "フォルダーなし", "label.folders": "フォルダー", "button.closeFolders": "フォルダーなしで全クリップを表示", "help.noFolders": "このフィルターのもとで値を持つクリップはありません。", "help.mostFolders": "最初の {n} フォルダーを表示しています。ほかを見るにはクリップを絞り込んでください。",
    "label.filtersActive": "フィルター、{n} 件有効", "button.showClips": "{n} クリップを表示",
    "label.moreWarnings": "ほか警告 {n} 件", "label.reportCopied": "インポート結果をコピーしました",
    "button.showReport": "結果を表示", "button.hideReport": "結果を隠す", "button.selectImported": "インポートした {n} クリップをすべて選択", "button.copyReport": "CSV をコピー", "button.saveReport": "CSV をダウンロード", "button.cancelFile": "{name} をキャンセル",
  },
);
