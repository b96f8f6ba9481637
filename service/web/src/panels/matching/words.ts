import { wordsOf } from "../../words/table";

export const m = wordsOf(
  {
    "help.intro": "A body follows a path or a game pad through frames of many clips: at each moment the frame that continues best is played.",
    "help.needs": "Choose clips of one skeleton with walks, turns and stops, of a known unit. A dozen are enough to start.",
    "label.clips": "Clips", "label.loading": "Loading {n} of {all}", "label.library": "{minutes} min of {n} clip|{minutes} min of {n} clips",
    "label.leftOut": "1 clip left out|{n} clips left out", "help.onlyFirst": "Only the first {minutes} minutes are loaded.",
    "label.stage": "Body", "button.play": "Play", "button.stop": "Pause", "button.anew": "Start over",
    "label.speed": "Speed (m/s)",
    "help.drive": "W A S D or arrow keys, or a game pad. Draw a path on the map.", "label.map": "Map: drag to draw a path", "label.paths": "Path",
    "label.circle": "Circle", "label.square": "Square", "label.eight": "Figure eight",
    "label.state": "{seconds} s, {n} cut|{seconds} s, {n} cuts", "label.distance": "{metres} m from the path", "label.arrived": "End of the path reached", "label.full": "Recording full: save it or start over",
    "button.save": "Save as clip", "label.newClip": "New clip", "label.defaultName": "Motion matching", "label.saved": "{name} saved", "button.open": "Open",
    "label.steeringKeys": "Steering", "label.forward": "Forward", "label.back": "Back", "label.left": "Left", "label.right": "Right",
  },
  {
    "help.intro": "몸이 경로나 게임 패드를 따라 여러 클립의 프레임을 이어 갑니다. 매 순간 가장 잘 이어지는 프레임을 재생합니다.",
    "help.needs": "걷기, 돌기, 멈추기가 있고 단위를 아는 같은 스켈레톤의 클립을 고르세요. 열두 개면 시작할 수 있습니다.",
    "label.clips": "클립", "label.loading": "{all}개 중 {n}개 불러옴", "label.library": "클립 {n}개, {minutes}분",
    "label.leftOut": "클립 {n}개 제외됨", "help.onlyFirst": "처음 {minutes}분만 불러왔습니다.",
    "label.stage": "몸", "button.play": "재생", "button.stop": "일시 정지", "button.anew": "처음부터",
    "label.speed": "속도 (m/s)",
    "help.drive": "W A S D 또는 화살표 키, 게임 패드로 조종합니다. 지도에 경로를 그릴 수 있습니다.", "label.map": "지도: 끌어서 경로 그리기", "label.paths": "경로",
    "label.circle": "원", "label.square": "사각형", "label.eight": "8자",
    "label.state": "{seconds}초, 이음매 {n}개", "label.distance": "경로에서 {metres} m", "label.arrived": "경로 끝에 도착", "label.full": "녹화가 가득 찼습니다. 저장하거나 처음부터 시작하세요",
    "button.save": "클립으로 저장", "label.newClip": "새 클립", "label.defaultName": "모션 매칭", "label.saved": "{name} 저장됨", "button.open": "열기",
    "label.steeringKeys": "조종", "label.forward": "앞으로", "label.back": "뒤로", "label.left": "왼쪽", "label.right": "오른쪽",
  },
);
