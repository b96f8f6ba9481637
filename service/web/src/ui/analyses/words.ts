/** Titles of the analyses that the repository has, and one sentence about each. */
import { wordsOf } from "../../words/table";

export const t = wordsOf(
  {
    "label.analysis_beats": "Beats and bars",
    "help.analysis_beats": "Motion beats of dance clips, where the body rests for a moment, their period, and bars of four.",
    "label.analysis_motion-graph": "Motion graph",
    "help.analysis_motion-graph": "Possible transitions between bars of dance clips, by distances of poses and movement, without dead ends.",
    "label.analysis_dance": "Dance to a tempo",
    "help.analysis_dance": "A new dance of any length to a tempo or to music, made of bars of dance clips, beat on beat.",
    "label.analysis_expression": "The space of facial expressions",
    "help.analysis_expression": "A map of all frames of facial takes with levels of detail, to find ways from face to face on.",
    "label.analysis_gait": "Gait parameters",
    "help.analysis_gait": "Spatio-temporal parameters of any number of trials, by trial and side, and pooled by subject.",
    "label.analysis_reach": "Reach motion from attributes",
    "help.analysis_reach": "A model that makes a reach for any age, height and hip point, or any other numbers that label clips.",
  },
  {
    "label.analysis_beats": "박과 마디",
    "help.analysis_beats": "춤 클립에서 몸이 잠시 멈추는 동작 박과 그 주기, 네 박으로 된 마디를 찾습니다.",
    "label.analysis_motion-graph": "모션 그래프",
    "help.analysis_motion-graph": "춤 클립의 마디 사이에서 가능한 전환을 자세와 움직임의 거리로 찾습니다. 막다른 마디는 없습니다.",
    "label.analysis_dance": "템포에 맞춘 춤",
    "help.analysis_dance": "춤 클립의 마디를 박에 맞추어 이어, 템포나 음악에 맞는 원하는 길이의 새 춤을 만듭니다.",
    "label.analysis_expression": "얼굴 표정 공간",
    "help.analysis_expression": "얼굴 테이크의 모든 프레임을 여러 단계의 지도로 만들어, 표정에서 표정으로 가는 길을 찾습니다.",
    "label.analysis_gait": "보행 지표",
    "help.analysis_gait": "여러 시행의 시공간 보행 지표를 시행별, 좌우별로, 그리고 대상자별로 모아 계산합니다.",
    "label.analysis_reach": "속성에 따른 손 뻗기 동작",
    "help.analysis_reach": "나이, 키, 엉덩이 위치나 클립에 붙은 다른 수치에 맞는 손 뻗기 동작을 만드는 모델입니다.",
  },
  {
    "label.analysis_beats": "拍と小節",
    "help.analysis_beats": "ダンスのクリップから、体が一瞬止まる動きの拍、その周期、四拍の小節を求めます。",
    "label.analysis_motion-graph": "モーショングラフ",
    "help.analysis_motion-graph": "ダンスのクリップの小節間で可能な遷移を、姿勢と動きの距離から求めます。行き止まりはありません。",
    "label.analysis_dance": "テンポに合わせたダンス",
    "help.analysis_dance": "ダンスのクリップの小節を拍に合わせてつなぎ、テンポや音楽に合う好きな長さのダンスを作ります。",
    "label.analysis_expression": "表情の空間",
    "help.analysis_expression": "表情テイクの全フレームを段階のある地図にし、表情から表情への道筋を探します。",
    "label.analysis_gait": "歩行パラメーター",
    "help.analysis_gait": "複数の試行の時空間パラメーターを、試行と左右ごとに、また被験者ごとにまとめて計算します。",
    "label.analysis_reach": "属性に応じたリーチ動作",
    "help.analysis_reach": "年齢、身長、股関節の位置など、クリップに付いた数値に合うリーチ動作を作るモデルです。",
  },
);

export type AnalysisWord = keyof typeof t.en;
