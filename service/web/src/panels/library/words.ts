import { wordsOf } from "../../words/table";

export const i = wordsOf(
  {
    "label.file": "File", "label.outcome": "Outcome", "label.message": "Message", "label.actions": "Actions", "label.findings": "Findings", "label.all": "All",
    "label.underway": "in progress", "label.refused": "import failed", "label.warned": "with warnings", "label.existing": "already here", "label.stored": "imported", "label.cancelled": "cancelled",
    "label.moreWarnings": "and {n} more warning|and {n} more warnings", "label.reportCopied": "Import report copied",
    "button.showReport": "Show report", "button.hideReport": "Hide report", "button.selectImported": "Select {n} imported clip|Select all {n} imported clips", "button.copyReport": "Copy CSV", "button.saveReport": "Download CSV", "button.cancelFile": "Cancel {name}",
  },
  {
    "label.file": "파일", "label.outcome": "결과", "label.message": "내용", "label.actions": "동작", "label.findings": "읽은 정보", "label.all": "전체",
    "label.underway": "진행 중", "label.refused": "가져오기 실패", "label.warned": "경고 있음", "label.existing": "이미 있음", "label.stored": "가져옴", "label.cancelled": "취소됨",
    "label.moreWarnings": "외 경고 {n}개", "label.reportCopied": "가져오기 보고서를 복사했습니다",
    "button.showReport": "보고서 보기", "button.hideReport": "보고서 접기", "button.selectImported": "가져온 클립 {n}개 모두 선택", "button.copyReport": "CSV 복사", "button.saveReport": "CSV 다운로드", "button.cancelFile": "{name} 취소",
  },
);
