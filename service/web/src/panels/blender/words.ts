import { wordsOf } from "../../words/table";

export const b = wordsOf(
  {
    intro: "A model of labelled clips makes the motion for any age, height and hip point, or any other numbers that label clips. Sliders ask, the body moves on.",
    needs: "It needs clips of one skeleton in which a hand reaches once, labelled with numbers (properties such as age, height, hbp). From a dozen it gets useful; gaps between examples are shown.",
    demo: "Make the demo model", demoName: "Belt reach", clipsTitle: "Fit a model to clips", options: "Options", nameOfModel: "Name", namePlaceholder: "of the clips' project", fit: "Fit a model", fitClips: "Fit a model to {n} clip|Fit a model to {n} clips",
    tooFew: "Choose at least {n} clip.|Choose at least {n} clips.", recent: "Models, the newest first", noModels: "No model yet.", noModel: "This result is no model of reaches.", otherModels: "Models",
    fitting: "Fitting", stage_waiting: "waiting", stage_reading: "reading clips", stage_sampling: "matching phases", "stage_components": "finding components", "stage_cross-validation": "choosing width and ridge", stage_errors: "leaving out one by one", stage_done: "done",
    excludeThese: "Exclude this clip and fit|Exclude these {n} and fit",
    examples: "Examples", fitTab: "Fit", blend: "Blend", corrections: "1 correction|{n} corrections",
    filterClips: "Clip, person, reason", usedOf: "{used} of {n} used", paste: "Paste a table", fitAgain: "Fit again", fitAgainWith: "Fit again with 1 correction|Fit again with {n} corrections", include: "Include", includeClip: "{name}: include", subject: "Person", state: "State", endShort: "end",
    moreRows: "and 1 more clip; filter to see it|and {n} more clips; filter to see them", notTaken: "excluded", corrected: "corrected", cellOf: "{name}: {attribute}", valueWritten: "{name}, {attribute}: saved as {value}", valueBack: "{name}: {value} again",
    pasteHelp: "The first line names the columns: name (or document), then properties with units in brackets. Cells may be parted by tabs, commas or semicolons; empty ones leave a value as it is.", writeValues: "Write the values", pasted: "Values of 1 clip written|Values of {n} clips written", pasteBack: "Values of 1 clip taken back|Values of {n} clips taken back",
    phasesOf: "Phases of {name}", setByHand: "Set phases by hand", asFound: "As before", openClip: "Open the clip", speedOf: "Angular speed of {joint} in {name}, its phases", inFrames: "frames", t1Edge: "t1: the reach begins", t2Edge: "t2: the hand is there", endEdge: "end: the last moment that counts", edgeAt: "frame {frames}, {seconds} s",
    prepare: "prepare", reach: "reach", settle: "settle",
    summary: "In words", fittedTo: "Fitted to {n} clip.|Fitted to {n} clips.", peopleMove: "One person moves in them.|{n} people move in them.", leftOutClips: "1 clip was left out; Examples says why.|{n} clips were left out; Examples says why.",
    keepsShare: "{n} component keeps {share} % of what differs; with them alone the hand is {error} off.|{n} components keep {share} % of what differs; with them alone the hand is {error} off.", unseenPeople: "For people it has not seen, joints are {degrees}° off and the hand {size}.", unseenClips: "For clips it has not seen, joints are {degrees}° off and the hand {size}.",
    betterThanNearest: "That is {share} % less than the nearest example alone.", notBetter: "The nearest example alone does as well.", likeLine: "A straight line does nearly as well: what the clips show is nearly linear.", noWarnings: "No warnings.", allParts: "All parts and numbers",
    variance: "Variance that the first components hold", eigenmotions: "eigenmotions", eigenposes: "eigenposes", keptHere: "{n} kept", componentsAxis: "components", leftOutErrors: "Errors for what was left out", errorOf: "Error of",
    of_joint: "all joints", of_arm: "arm", of_hand: "hand", of_t1: "t1", of_t2: "t2", of_end: "end", degreesHelp: "Degrees, in the mean over joints and time.", handHelp: "Distance of the hand, in the mean over time.", framesHelp: "Frames at the model's rate.",
    peopleLeftOut: "People left out one by one", clipsLeftOut: "Clips left out one by one", by_model: "this model", by_linear: "straight line", by_nearest: "nearest clip", by_components: "components",
    tried: "Width s and ridge λ that were tried", tried_motion: "of the motion", tried_times: "of the phase times", triedHelp: "Error of left-out coefficients; less is better. Taken: s = {s}, λ = {lam}.",
    made: "Made motion", madeOf: "A motion made for {values}", alone: "Alone", side: "Side by side", ghost: "Ghost", nearest: "Nearest example", nearestIs: "nearest: {name}", newMotionIn: "new motion in {ms} ms", madePhases: "Angular speed of {joint}: this motion and its phases; examples behind", phasesWords: "Angular speed of the made motion. Prepare until {t1} s, reach until {t2} s, settle until {end} s.",
    examplesOf: "1 example|{n} examples", people: "1 person|{n} people", componentsKeep: "1 component keeps {share} %|{n} components keep {share} %",
    valueOf: "{name}, value", nobodyHere: "nobody recorded here", inside: "inside", gap: "gap", outside: "outside", twoAtOnce: "Two at once", across: "across", upwards: "up", padOf: "{x} and {y}",
    trust: "How far to trust it", insideData: "Inside the data", gapData: "In a gap", outsideData: "Outside the data", aboutAtHand: "about {size} off at the hand", moreAtHand: "more than {size} off at the hand", gapWords: "{name}: nobody between {low} and {high} {unit} was recorded. The motion is calculated.", outsideWords: "No mixture of examples is so. The motion goes on beyond them.", sparseWords: "The nearest example is {times} times as far as examples usually are.",
    nearestValues: "Nearest example:", goThere: "Go there", madeOfExamples: "Examples that count most",
    saveAsClip: "Save as clip", exportMade: "Export what was made", pictureOfIt: "Picture", saved: "{name}: saved", savedHelp: "It becomes a document like any other and says from which examples and values it was made.",
    name_age: "Age", name_height: "Height", name_hbp: "Hip point", unit_year: "years",
    "why_too-few-frames": "too few frames", "why_too-slow": "hardly moves", "why_no-clear-peak": "no clear reach", "why_peak-at-border": "reach cut off at an end", "why_missing-attribute": "a value is missing", "why_attribute-not-a-number": "a value is no number", "why_missing-samples": "samples are missing", "why_zero-quaternion": "a rotation is none",
    "flag_t1-from-threshold": "start guessed", "flag_no-preparation": "begins at once", "flag_t2-from-8-percent": "end of reach guessed", "flag_t2-from-16-percent": "end of reach guessed", "flag_speed-never-settles": "never comes to rest", flag_given: "set by hand",
    "warn_gap-filled": "Short gaps were filled.", warn_jump: "A joint jumps in a frame.", "warn_bones-differ": "Bodies differ much in size.", "warn_constant-attribute": "A value is the same in all clips: its slider changes nothing.", "warn_two-values": "A value has but two levels: what lies between was never seen.", "warn_two-people": "Only two people: what differs between them cannot be told from what a value does.", "warn_collinear-attributes": "The values depend on one another.", "warn_far-from-reference": "A pose is far from all others.", "warn_ill-conditioned": "The equations are close to unsolvable.",
  },
  {
    intro: "라벨이 붙은 클립의 모델이 나이, 키, 엉덩이점 같은 수에 맞는 동작을 만듭니다. 슬라이더를 움직이면 몸이 이어서 움직입니다.",
    needs: "손을 한 번 뻗는 같은 스켈레톤의 클립과 수로 된 특성(나이, 키, hbp 등)이 필요합니다. 열두 개 정도부터 쓸모가 있으며, 예제 사이의 빈 구간을 보여 줍니다.",
    demo: "데모 모델 만들기", demoName: "벨트 뻗기", clipsTitle: "클립에 모델 맞추기", options: "옵션", nameOfModel: "이름", namePlaceholder: "클립의 프로젝트 이름", fit: "모델 맞추기", fitClips: "클립 {n}개에 모델 맞추기",
    tooFew: "클립을 {n}개 이상 고르세요.", recent: "모델, 최신순", noModels: "아직 모델이 없습니다.", noModel: "이 결과는 뻗기 모델이 아닙니다.", otherModels: "모델 목록",
    fitting: "맞추는 중", stage_waiting: "대기 중", stage_reading: "클립 읽는 중", stage_sampling: "국면 맞추는 중", "stage_components": "성분 찾는 중", "stage_cross-validation": "너비와 능선값 고르는 중", stage_errors: "하나씩 빼 보는 중", stage_done: "완료",
    excludeThese: "{n}개를 빼고 맞추기",
    examples: "예제", fitTab: "적합도", blend: "블렌드", corrections: "수정 {n}건",
    filterClips: "클립, 사람, 이유", usedOf: "{n}개 중 {used}개 사용", paste: "표 붙여넣기", fitAgain: "다시 맞추기", fitAgainWith: "수정 {n}건으로 다시 맞추기", include: "포함", includeClip: "{name}: 포함", subject: "사람", state: "상태", endShort: "끝",
    moreRows: "외 클립 {n}개. 걸러서 보세요.", notTaken: "제외함", corrected: "수정함", cellOf: "{name}: {attribute}", valueWritten: "{name}, {attribute}: {value}, 저장했습니다", valueBack: "{name}: {value}, 되돌렸습니다",
    pasteHelp: "첫 줄에 열 이름을 쓰세요. name(또는 document), 그다음 특성과 괄호 안의 단위입니다. 칸은 탭, 쉼표, 쌍반점으로 나누며 빈 칸은 값을 그대로 둡니다.", writeValues: "값 쓰기", pasted: "클립 {n}개의 값을 썼습니다", pasteBack: "클립 {n}개의 값을 되돌렸습니다",
    phasesOf: "{name}의 국면", setByHand: "국면 직접 정하기", asFound: "이전대로", openClip: "클립 열기", speedOf: "{name}에서 {joint}의 각속력과 국면", inFrames: "프레임", t1Edge: "t1: 뻗기 시작", t2Edge: "t2: 손이 닿음", endEdge: "끝: 마지막 순간", edgeAt: "{frames}프레임, {seconds} s",
    prepare: "준비", reach: "뻗기", settle: "마무리",
    summary: "요약", fittedTo: "클립 {n}개에 맞췄습니다.", peopleMove: "{n}명이 움직입니다.", leftOutClips: "클립 {n}개를 뺐습니다. 이유는 예제에 있습니다.",
    keepsShare: "성분 {n}개가 차이의 {share} %를 담으며, 이것만으로 손은 {error} 벗어납니다.", unseenPeople: "처음 보는 사람에 대해 관절은 {degrees}°, 손은 {size} 벗어납니다.", unseenClips: "처음 보는 클립에 대해 관절은 {degrees}°, 손은 {size} 벗어납니다.",
    betterThanNearest: "가장 가까운 예제보다 {share} % 적습니다.", notBetter: "가장 가까운 예제만으로도 같은 정도입니다.", likeLine: "직선도 거의 같은 정도입니다. 클립이 보여 주는 관계는 거의 선형입니다.", noWarnings: "경고가 없습니다.", allParts: "모든 부분과 수치",
    variance: "처음 성분들이 담은 분산", eigenmotions: "고유동작", eigenposes: "고유자세", keptHere: "{n}개 사용", componentsAxis: "성분 수", leftOutErrors: "뺀 것에 대한 오차", errorOf: "오차 종류",
    of_joint: "모든 관절", of_arm: "팔", of_hand: "손", of_t1: "t1", of_t2: "t2", of_end: "끝", degreesHelp: "관절과 시간에 대한 평균 각도입니다.", handHelp: "시간에 대한 손 위치 차이의 평균입니다.", framesHelp: "모델 속도의 프레임 수입니다.",
    peopleLeftOut: "사람을 하나씩 뺐을 때", clipsLeftOut: "클립을 하나씩 뺐을 때", by_model: "이 모델", by_linear: "직선", by_nearest: "가까운 클립", by_components: "성분",
    tried: "시험한 너비 s와 능선값 λ", tried_motion: "동작", tried_times: "국면 시각", triedHelp: "빼 둔 계수의 오차이며 작을수록 좋습니다. 고른 값: s = {s}, λ = {lam}.",
    made: "만든 동작", madeOf: "{values}에 맞춰 만든 동작", alone: "단독", side: "나란히", ghost: "잔상", nearest: "가장 가까운 예제", nearestIs: "가까운 예제: {name}", newMotionIn: "새 동작 {ms} ms", madePhases: "{joint}의 각속력: 이 동작과 국면, 뒤는 예제", phasesWords: "만든 동작의 각속력. 준비 {t1} s까지, 뻗기 {t2} s까지, 마무리 {end} s까지.",
    examplesOf: "예제 {n}개", people: "{n}명", componentsKeep: "성분 {n}개가 {share} % 유지",
    valueOf: "{name}, 값", nobodyHere: "기록된 사람 없음", inside: "범위 안", gap: "빈 구간", outside: "범위 밖", twoAtOnce: "두 가지 함께", across: "가로", upwards: "세로", padOf: "{x}, {y}",
    trust: "믿을 수 있는 정도", insideData: "범위 안", gapData: "빈 구간", outsideData: "범위 밖", aboutAtHand: "손에서 약 {size} 차이", moreAtHand: "손에서 {size} 넘는 차이", gapWords: "{name}: {low}~{high} {unit} 사이에는 기록된 사람이 없습니다. 계산한 동작입니다.", outsideWords: "예제를 섞어서는 나오지 않는 값입니다. 예제 너머로 이어 계산합니다.", sparseWords: "가장 가까운 예제가 보통의 {times}배 떨어져 있습니다.",
    nearestValues: "가장 가까운 예제:", goThere: "그곳으로", madeOfExamples: "영향이 큰 예제",
    saveAsClip: "클립으로 저장", exportMade: "만든 동작 내보내기", pictureOfIt: "그림", saved: "{name}: 저장했습니다", savedHelp: "다른 것과 같은 문서가 되며, 어떤 예제와 값으로 만들었는지 담습니다.",
    name_age: "나이", name_height: "키", name_hbp: "엉덩이점", unit_year: "세",
    "why_too-few-frames": "프레임이 너무 적음", "why_too-slow": "거의 움직이지 않음", "why_no-clear-peak": "뚜렷한 뻗기 없음", "why_peak-at-border": "뻗기가 끝에서 잘림", "why_missing-attribute": "값이 없음", "why_attribute-not-a-number": "값이 수가 아님", "why_missing-samples": "표본이 빠짐", "why_zero-quaternion": "회전 값이 없음",
    "flag_t1-from-threshold": "시작은 추정", "flag_no-preparation": "바로 시작", "flag_t2-from-8-percent": "뻗기 끝은 추정", "flag_t2-from-16-percent": "뻗기 끝은 추정", "flag_speed-never-settles": "멈추지 않음", flag_given: "직접 정함",
    "warn_gap-filled": "짧은 빈 곳을 채웠습니다.", warn_jump: "한 프레임에서 관절이 튑니다.", "warn_bones-differ": "몸 크기가 많이 다릅니다.", "warn_constant-attribute": "모든 클립에서 같은 값이라 슬라이더가 아무것도 바꾸지 않습니다.", "warn_two-values": "값이 두 가지뿐이라 그 사이는 본 적이 없습니다.", "warn_two-people": "두 명뿐이라 사람의 차이와 값의 차이를 구별할 수 없습니다.", "warn_collinear-attributes": "값들이 서로 의존합니다.", "warn_far-from-reference": "다른 자세와 아주 먼 자세가 있습니다.", "warn_ill-conditioned": "방정식이 거의 풀리지 않습니다.",
  },
);

type Name = keyof typeof b.en;

/** Whether the table has such a word. */
export const isWord = (name: string): name is Name => name in b.en;

const orItself = (kind: string, name: string): string => { const word = `${kind}_${name}`; return isWord(word) ? b(word) : name; };

export const nameOf = (attribute: string): string => orItself("name", attribute);
export const unitOf = (unit: string): string => orItself("unit", unit);
export const reasonOf = (code: string): string => orItself("why", code);
export const flagOf = (code: string): string => orItself("flag", code);
