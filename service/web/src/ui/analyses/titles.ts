/** Titles and stages of analyses in the language of the studio; those of other packages are as these have them. */
import { t, type AnalysisWord } from "./words";

interface Described {
  name: string;
  title: string;
  description: string;
}

const wordOf = (key: string, otherwise: string): string => (key in t.en ? t(key as AnalysisWord) : otherwise);

export const analysisTitle = ({ name, title }: Pick<Described, "name" | "title">): string =>
  wordOf(`label.analysis_${name}`, title);

export const analysisHelp = ({ name, description }: Pick<Described, "name" | "description">): string =>
  wordOf(`help.analysis_${name}`, description);

export const stageOf = ({ stage }: { stage?: string | null | undefined }): string =>
  stage ? wordOf(`label.stage_${stage.replaceAll(" ", "_")}`, stage) : "";
