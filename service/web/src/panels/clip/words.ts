import { wordsOf } from "../../words/table";

export const r = wordsOf(
  {
    "label.proposals": "Proposals", "label.proposalNumber": "Proposal {n}", "label.proposed": "Proposal {n} created for review",
    "button.propose": "Propose", "label.message": "Message (optional)", "help.propose": "Suggest this change; others review it before it is applied.",
    "help.viewersPropose": "Viewers propose changes; editors apply them.", "help.reviewRequired": "This project requires a review of changes.",
    "label.pending": "1 proposal|{n} proposals", "help.noProposals": "No open proposals. Use Propose beside Save, or in an edit of frames.",
    "label.state_open": "Open", "label.state_approved": "Approved by {name}", "label.state_applied": "Applied as revision {n}", "label.state_closed": "Closed",
    "button.approve": "Approve", "button.applyProposal": "Apply", "button.closeProposal": "Close", "button.rebase": "Rebase",
    "help.outdated": "Made for revision {n}. Rebase it to the current revision before it is applied.",
    "help.needsApproval": "Another editor has to approve it first.", "help.ownProposal": "Another editor has to approve your proposal.",
    "label.applied": "Proposal {n} applied as revision {revision}", "button.endedToo": "Show 1 applied or closed|Show {n} applied or closed",
    "help.notHere": "These frames are not in the revision that is shown.",
    "help.ghostProposed": "The proposed motion is the ghost. Hold C to see it alone.",
    "label.bodyChoice": "Body shown", "label.unknownCharacter": "removed character", "button.importCharacter": "Import a character…",
    "help.draftAsSticks": "The character shows the saved motion. Save your changes to see them on it.",
  },
  {
    "label.proposals": "제안", "label.proposalNumber": "제안 {n}", "label.proposed": "검토할 제안 {n}을(를) 만들었습니다",
    "button.propose": "제안", "label.message": "메시지(선택)", "help.propose": "변경을 제안합니다. 다른 사람이 검토한 뒤 적용됩니다.",
    "help.viewersPropose": "보기 권한으로는 변경을 제안하고, 편집자가 적용합니다.", "help.reviewRequired": "이 프로젝트는 변경에 검토가 필요합니다.",
    "label.pending": "제안 {n}개", "help.noProposals": "열린 제안이 없습니다. 저장 옆이나 프레임 편집에서 ‘제안’을 누르세요.",
    "label.state_open": "열림", "label.state_approved": "{name} 승인", "label.state_applied": "리비전 {n}(으)로 적용됨", "label.state_closed": "닫힘",
    "button.approve": "승인", "button.applyProposal": "적용", "button.closeProposal": "닫기", "button.rebase": "현재 리비전으로 옮기기",
    "help.outdated": "리비전 {n}에 대한 제안입니다. 적용하려면 현재 리비전으로 옮기세요.",
    "help.needsApproval": "먼저 다른 편집자가 승인해야 합니다.", "help.ownProposal": "본인의 제안은 다른 편집자가 승인해야 합니다.",
    "label.applied": "제안 {n}을(를) 리비전 {revision}(으)로 적용했습니다", "button.endedToo": "적용되거나 닫힌 {n}개 보기",
    "help.notHere": "보고 있는 리비전에는 이 프레임이 없습니다.",
    "help.ghostProposed": "흐린 몸이 제안된 동작입니다. C를 누르고 있으면 그것만 보입니다.",
    "label.bodyChoice": "표시할 몸", "label.unknownCharacter": "삭제된 캐릭터", "button.importCharacter": "캐릭터 가져오기…",
    "help.draftAsSticks": "캐릭터는 저장된 동작을 보여 줍니다. 변경 내용을 저장하면 캐릭터에 나타납니다.",
  },
);

/** Of the video or sound beside the motion. */
export const v = wordsOf(
  {
    "label.video": "Video", "button.openVideo": "Show large, to align and measure", "button.align": "Align with the motion",
    "help.align": "Find a moment in the video or sound, then the same moment in the motion.",
    "help.findMoment": "1 of 2: find a clear moment, such as a foot strike or a clap.",
    "button.earlier": "Move back 1/30 s", "button.later": "Move on 1/30 s", "button.useMoment": "Use this moment",
    "help.findFrame": "2 of 2: find the same moment in the motion, on the timeline. The video stays at {seconds} s.",
    "button.useFrame": "Use frame {frame}", "label.aligned": "The motion begins at {seconds} s of the file",
    "button.measureAngle": "Measure angle", "button.measureLength": "Measure length",
    "label.angle": "Angle", "label.length": "Length", "label.knownLength": "True length", "label.pointOf": "Point {n} of {text}",
    "button.goTo": "Go to {seconds} s",
    "help.drawings": "Drag the points. Enter the true length of one line to measure in metres. Drawings are not saved.",
    "help.drawingsScaled": "Metres are right only at the distance from the camera of the line with the true length. Drawings are not saved.",
  },
  {
    "label.video": "비디오", "button.openVideo": "크게 보고 맞추고 재기", "button.align": "동작과 맞추기",
    "help.align": "비디오나 소리에서 한 순간을 찾고, 동작에서 같은 순간을 찾습니다.",
    "help.findMoment": "1/2: 발이 닿거나 손뼉을 치는 것처럼 뚜렷한 순간을 찾으세요.",
    "button.earlier": "1/30초 뒤로", "button.later": "1/30초 앞으로", "button.useMoment": "이 순간 사용",
    "help.findFrame": "2/2: 타임라인에서 동작의 같은 순간을 찾으세요. 비디오는 {seconds}초에 머뭅니다.",
    "button.useFrame": "{frame}프레임 사용", "label.aligned": "동작이 파일의 {seconds}초에서 시작합니다",
    "button.measureAngle": "각도 재기", "button.measureLength": "길이 재기",
    "label.angle": "각도", "label.length": "길이", "label.knownLength": "실제 길이", "label.pointOf": "{text}의 점 {n}",
    "button.goTo": "{seconds}초로 이동",
    "help.drawings": "점을 끌어 옮기세요. 한 선의 실제 길이를 입력하면 미터로 잽니다. 그린 것은 저장되지 않습니다.",
    "help.drawingsScaled": "실제 길이를 입력한 선과 카메라까지의 거리가 같은 곳에서만 미터가 맞습니다. 그린 것은 저장되지 않습니다.",
  },
);
