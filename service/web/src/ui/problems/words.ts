/** Titles of the kinds of problems. */
import { wordsOf } from "../../words/table";

export const p = wordsOf(
  {
    "label.problem_format-error": "Format error", "label.problem_unsupported-error": "Unsupported error",
    "label.problem_document-error": "Document error", "label.problem_conversion-error": "Conversion error",
    "label.problem_vocabulary-error": "Vocabulary error", "label.problem_query-error": "Query error",
    "label.problem_request-error": "Request error", "label.problem_limit-error": "Limit error",
    "label.problem_size-error": "Size error", "label.problem_analysis-error": "Analysis error",
    "label.problem_not-found-error": "Not found error",
    "label.problem_precondition-error": "Precondition error", "label.problem_conflict-error": "Conflict error",
    "label.problem_access-error": "Access error", "label.problem_store-error": "Store error",
    "label.problem_damage-error": "Damage error", "label.problem_unavailable-error": "Unavailable error",
    "label.problem_busy-error": "Busy error", "label.problem_share-error": "Share error",
    "label.problem_attempts-error": "Attempts error", "label.problem_space-error": "Space error",
    "label.problem_invalid-request": "Invalid request",
  },
  {
    "label.problem_format-error": "형식 오류", "label.problem_unsupported-error": "지원하지 않는 형식",
    "label.problem_document-error": "문서 오류", "label.problem_conversion-error": "변환 오류",
    "label.problem_vocabulary-error": "동작 이름 오류", "label.problem_query-error": "질의 오류",
    "label.problem_request-error": "요청 오류", "label.problem_limit-error": "한도 초과",
    "label.problem_size-error": "크기 초과", "label.problem_analysis-error": "분석 오류",
    "label.problem_not-found-error": "찾을 수 없음", "label.problem_precondition-error": "다른 리비전",
    "label.problem_conflict-error": "충돌", "label.problem_access-error": "권한 없음",
    "label.problem_store-error": "저장소 오류", "label.problem_damage-error": "손상된 데이터",
    "label.problem_unavailable-error": "지금은 사용할 수 없음", "label.problem_busy-error": "서버가 바쁨",
    "label.problem_share-error": "요청이 너무 많음", "label.problem_attempts-error": "시도 횟수 초과",
    "label.problem_space-error": "저장 공간 부족", "label.problem_invalid-request": "잘못된 요청",
  },
  {
    "label.problem_format-error": "形式エラー", "label.problem_unsupported-error": "未対応の形式",
    "label.problem_document-error": "ドキュメントエラー", "label.problem_conversion-error": "変換エラー",
    "label.problem_vocabulary-error": "動作名エラー", "label.problem_query-error": "クエリエラー",
    "label.problem_request-error": "リクエストエラー", "label.problem_limit-error": "上限超過",
    "label.problem_size-error": "サイズ超過", "label.problem_analysis-error": "解析エラー",
    "label.problem_not-found-error": "見つかりません", "label.problem_precondition-error": "リビジョンの不一致",
    "label.problem_conflict-error": "競合", "label.problem_access-error": "権限がありません",
    "label.problem_store-error": "ストアエラー", "label.problem_damage-error": "データの破損",
    "label.problem_unavailable-error": "現在利用できません",
    "label.problem_busy-error": "サーバーが混雑しています",
    "label.problem_share-error": "リクエストが多すぎます", "label.problem_attempts-error": "試行回数の超過",
    "label.problem_space-error": "ディスクの空き不足", "label.problem_invalid-request": "無効なリクエスト",
  },
);

export type ProblemWord = keyof typeof p.en;
